#pragma once

#include "errors.hpp"
#include "values.hpp"

#include <clsdf/device.hpp>
#include <clsdf/distance_transform.hpp>
#include <clsdf/field.hpp>
#include <clsdf/link_plan.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/plan.hpp>
#include <clsdf/point_plan.hpp>
#include <clsdf/scene.hpp>
#include <clsdf/sparse.hpp>
#include <clsdf/sparse_plan.hpp>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf::c {

/// The kind is the first word of every object, so that a handle of another kind is told.
enum class Kind : std::uint64_t {
    devices = 0x636c736466000001,
    device,
    mesh,
    transform,
    plan,
    field,
    points,
    thread_limit,
    field_writer,
    sparse_field,
    sparse_writer,
    sparse_plan,
    point_plan,
    link_plan,
    scene,
    cuda_device,
    cuda_memory,
    cuda_arrays,
};

const char* name_of(Kind kind) noexcept;

/// A counted object. Not virtual: the library that made it also gives the function that destroys it.
struct Object {
    Kind kind;
    std::atomic<std::int64_t> references{1};
    void (*destroy)(Object*);

    Object(Kind kind_in, void (*destroy_in)(Object*)) : kind(kind_in), destroy(destroy_in) {}
    Object(const Object&) = delete;
    Object& operator=(const Object&) = delete;
};

template <typename Handle>
struct Counted : Object {
    Counted() : Object(Handle::own_kind, [](Object* object) { delete static_cast<Handle*>(object); }) {}
};

inline void retain(Object* object) noexcept {
    if (object != nullptr) object->references.fetch_add(1, std::memory_order_relaxed);
}

inline void release(Object* object) noexcept {
    if (object != nullptr && object->references.fetch_sub(1, std::memory_order_acq_rel) == 1) object->destroy(object);
}

/// The object behind a handle. Throws Error(invalid_argument) for null or another kind.
template <typename Handle>
Handle& of(Handle* handle) {
    constexpr Kind expected = std::remove_const_t<Handle>::own_kind;
    if (handle == nullptr)
        throw misuse(std::string("the ") + name_of(expected) + " is null; give a handle that a call of clsdf made");
    if (handle->kind != expected)
        throw misuse(std::string("the handle given as a ") + name_of(expected) + " is one of a " +
                     name_of(handle->kind) + "; give a handle of the right kind");
    return *handle;
}

}  // namespace clsdf::c

struct clsdf_devices : clsdf::c::Counted<clsdf_devices> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::devices;
    std::vector<clsdf::DeviceInfo> infos;
};

struct clsdf_device : clsdf::c::Counted<clsdf_device> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::device;
    clsdf::Device device;
    /// The texts of clsdf_device_describe(), which live as long as the handle; asked once.
    mutable std::once_flag is_described;
    mutable clsdf::DeviceInfo info;

    explicit clsdf_device(clsdf::Device device_in) : device(std::move(device_in)) {}
};

struct clsdf_mesh : clsdf::c::Counted<clsdf_mesh> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::mesh;
    clsdf::Mesh mesh;
    std::int32_t index_base;
    std::vector<std::uint32_t> given_faces{};   // of an outer surface
    std::vector<std::uint32_t> given_bodies{};  // of that of a scene

    explicit clsdf_mesh(clsdf::Mesh mesh_in, std::int32_t index_base_in = 0)
        : mesh(std::move(mesh_in)), index_base(index_base_in) {}
};

struct clsdf_transform : clsdf::c::Counted<clsdf_transform> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::transform;
    clsdf::DistanceTransform transform;
    std::int32_t index_base;

    clsdf_transform(clsdf::DistanceTransform transform_in, std::int32_t index_base_in)
        : transform(std::move(transform_in)), index_base(index_base_in) {}
};

struct clsdf_scene : clsdf::c::Counted<clsdf_scene> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::scene;
    clsdf::Scene scene;
    std::int32_t index_base;

    clsdf_scene(clsdf::Scene scene_in, std::int32_t index_base_in)
        : scene(std::move(scene_in)), index_base(index_base_in) {}
};

namespace clsdf::c {

template <class Self, class Made, Kind kind>
struct CountedPlan : Counted<Self> {
    static constexpr Kind own_kind = kind;
    Made plan;
    std::int32_t index_base;

    CountedPlan(Made plan_in, std::int32_t index_base_in) : plan(std::move(plan_in)), index_base(index_base_in) {}
};

}  // namespace clsdf::c

struct clsdf_plan : clsdf::c::CountedPlan<clsdf_plan, clsdf::Plan, clsdf::c::Kind::plan> {
    using CountedPlan::CountedPlan;
};

struct clsdf_sparse_plan : clsdf::c::CountedPlan<clsdf_sparse_plan, clsdf::SparsePlan, clsdf::c::Kind::sparse_plan> {
    using CountedPlan::CountedPlan;
};

struct clsdf_point_plan : clsdf::c::CountedPlan<clsdf_point_plan, clsdf::PointPlan, clsdf::c::Kind::point_plan> {
    using CountedPlan::CountedPlan;
};

struct clsdf_link_plan : clsdf::c::CountedPlan<clsdf_link_plan, clsdf::LinkPlan, clsdf::c::Kind::link_plan> {
    using CountedPlan::CountedPlan;
};

struct clsdf_field : clsdf::c::Counted<clsdf_field> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::field;
    clsdf::Field field;
    std::int32_t index_base;  ///< of its triangles

    explicit clsdf_field(clsdf::Field field_in, std::int32_t index_base_in = 0)
        : field(std::move(field_in)), index_base(index_base_in) {}
};

struct clsdf_sparse_field : clsdf::c::Counted<clsdf_sparse_field> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::sparse_field;
    clsdf::SparseField field;
    std::int32_t index_base;           ///< of its triangles
    std::vector<clsdf_target> values;  ///< those of clsdf_sparse_field_slab()

    explicit clsdf_sparse_field(clsdf::SparseField field_in, std::int32_t index_base_in = 0)
        : field(std::move(field_in)), index_base(index_base_in), values(clsdf::c::as_c(field.values())) {}
};

struct clsdf_points : clsdf::c::Counted<clsdf_points> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::points;
    std::vector<clsdf::Vec3> positions;
};

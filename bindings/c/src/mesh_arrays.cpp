#include "mesh_arrays.hpp"

#include "core/least_index.hpp"
#include "errors.hpp"
#include "mesh/input_arrays.hpp"
#include "values.hpp"

#include <algorithm>
#include <array>

namespace clsdf::c {

namespace {

template <typename Index>
std::vector<Triangle> triangles_from_0(const MeshView& mesh, const std::string& name) {
    const InputArray& array = mesh.triangles();
    const std::size_t vertices = mesh.vertices().count;
    const auto is_in_range = [&](Index index) { return index >= 1 && static_cast<std::uint64_t>(index) <= vertices; };
    std::vector<Triangle> triangles(array.count);
    LeastIndex refused(array.count);
    for_each_triple<Index>(array, [&](std::size_t i, const std::array<Index, 3>& indices) {
        for (std::size_t k = 0; k < 3; ++k) triangles[i][k] = static_cast<std::uint32_t>(indices[k]) - 1;
        if (!std::ranges::all_of(indices, is_in_range)) refused.take(i);
    });
    if (refused.get() == array.count) return triangles;
    const auto indices = triple_of<Index>(array, refused.get());
    throw Error(ErrorCode::invalid_mesh,
                name + ": triangle " + std::to_string(refused.get() + 1) + " has the vertex index " +
                    std::to_string(*std::ranges::find_if_not(indices, is_in_range)) +
                    "; with index base 1 triangles count from 1, and indices are 1 to " + std::to_string(vertices));
}

std::vector<Triangle> triangles_from_0(const MeshView& mesh, const std::string& name) {
    if (mesh.triangles().device != nullptr)
        throw Error(ErrorCode::unsupported,
                    "triangles with index base 1 lie in memory of the device; give an array of the host");
    switch (mesh.triangles().type) {
        case ElementType::int32:
            return triangles_from_0<std::int32_t>(mesh, name);
        case ElementType::int64:
            return triangles_from_0<std::int64_t>(mesh, name);
        case ElementType::uint64:
            return triangles_from_0<std::uint64_t>(mesh, name);
        default:
            return triangles_from_0<std::uint32_t>(mesh, name);
    }
}

}  // namespace

MeshArrays::MeshArrays(const clsdf_mesh_arrays* arrays) {
    const clsdf_mesh_arrays from = read_given(arrays, CLSDF_MESH_ARRAYS_INIT, "clsdf_mesh_arrays");
    check_reserved(from.reserved, "clsdf_mesh_arrays");
    index_base_ = checked_index_base(from.index_base);
    name_ = text_or(from.name, "mesh");
    view_.emplace(input_of(&from.vertices, "vertices"), input_of(&from.triangles, "triangles"));
    if (index_base_ == 0) return;
    triangles_ = triangles_from_0(*view_, name_);
    view_.emplace(view_->vertices(), triangles_);
}

}  // namespace clsdf::c

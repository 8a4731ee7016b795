#include "disguise/uses.hpp"

#include <clsdf/fraction_plan.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/link_plan.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/scene.hpp>

#include <limits>
#include <utility>

namespace clsdf::test {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

const std::vector<LinkDirection>& directions() {
    static const std::vector<LinkDirection> all = stencil("D3Q19");
    return all;
}

Bytes bytes_of_links(const Links& links) {
    return bytes_of_all(links.samples, links.directions, links.q, links.triangles, links.counts, links.flags,
                        links.inside.bits);
}

Bytes bytes_of_crossings(const Crossings& crossings) {
    Bytes bytes = bytes_of_all(crossings.inside.bits);
    for (const EdgeCrossings& edges : crossings.axes) {
        const Bytes more = bytes_of_all(edges.coordinates, edges.triangles, edges.counts);
        bytes.insert(bytes.end(), more.begin(), more.end());
    }
    return bytes;
}

/// Two bodies that overlap, and an instance of each.
std::shared_ptr<Scene> scene(Surface surface = Surface::given) {
    auto bodies = std::make_shared<Scene>(test_device(), SceneOptions{.surface = surface});
    const Mesh shape = make_shape("cube");
    bodies->add(shape);
    bodies->add(tilted(shape), {.translation = {0.6, 0.2, 0.1}});
    bodies->add_instance(0, {.translation = {0, 3, 0}});
    bodies->add_instance(1, {.translation = {0, 3, 1}});
    return bodies;
}
const Grid& scene_grid() {
    static const Grid around{{-1.5, -1.5, -1.5}, {0.25, 0.25, 0.25}, {18, 26, 16}, {}};
    return around;
}
std::vector<Vec3> points_of_scene() {
    std::vector<Vec3> points;
    for (std::int64_t i = 0; i < 60; ++i) points.push_back(scene_grid().position(i % 7 * 2, i % 11 * 2, i % 5 * 3));
    return points;
}
Bytes query_of_scene(const Scene& bodies) {
    const std::vector<Vec3> asked = points_of_scene();
    std::vector<float> distance(asked.size(), 7);
    std::vector<std::uint32_t> triangle(asked.size(), 7);
    bodies.query(asked, infinity, {.outputs = {{Output::distance, distance}, {Output::triangle, triangle}}});
    return bytes_of_all(distance, triangle);
}

const OuterSurface& surface() {
    static const OuterSurface of_mesh = outer(mesh());
    return of_mesh;
}

/// Arrays of rows in memory of the device.
struct LinkBuffers {
    static constexpr std::size_t room = 20000;
    cl::Buffer q = on_device(std::vector<double>(room, 7)), triangles = on_device(std::vector<std::uint32_t>(room, 7)),
               count = on_device(std::vector<DeviceLinkCount>(1));

    LinkTargets targets() const { return {.room = room, .q = q(), .triangles = triangles()}; }
    Bytes found() const {
        const auto counts = read_apart<DeviceLinkCount>(count, 1);
        const auto rows = static_cast<std::size_t>(counts[0].links);
        return bytes_of_all(counts, read_apart<double>(q, rows), read_apart<std::uint32_t>(triangles, rows));
    }
};
struct CellBuffers {
    static constexpr std::size_t room = 8000;
    cl::Buffer cells = on_device(std::vector<std::int32_t>(3 * room, 7)),
               volume = on_device(std::vector<double>(room, 7)), count = on_device(std::vector<DeviceFractionCount>(1));

    FractionRows targets() const { return {.room = room, .cells = cells(), .volume = volume()}; }
    Bytes found() const {
        const auto counts = read_apart<DeviceFractionCount>(count, 1);
        const auto rows = static_cast<std::size_t>(counts[0].rows);
        return bytes_of_all(counts, read_apart<std::int32_t>(cells, 3 * rows), read_apart<double>(volume, rows));
    }
};

DistanceTransform restricted(const DistanceTransform& whole) {
    const Grid part = small_grid().part({0, 0, 0}, {12, 12, 12});
    return whole.restrict_to(Region{part.box(), 3 * part.voxel(), part.voxel()});
}
Bytes field_of_part(const DistanceTransform& part) {
    return bytes_of_field(
        part.compute(small_grid().part({0, 0, 0}, {12, 12, 12}), small_band(), outputs_of_uses).slab());
}

}  // namespace

const std::vector<Use>& uses_of_rows() {
    static const std::vector<Use> all{
        use("links", [](auto& used) { return bytes_of_links(used.links(small_grid(), directions())); }),
        use("links by slabs",
            [](auto& used) {
                Bytes bytes;
                used.links(small_grid(), directions(), [&](const Grid&, const Links& links) {
                    const Bytes more = bytes_of_links(links);
                    bytes.insert(bytes.end(), more.begin(), more.end());
                });
                return bytes;
            }),
        use("links to the device",
            [](auto& used) {
                const LinkBuffers buffers;
                std::size_t count = 0;
                used.links(small_grid(), directions(), buffers.targets(), count);
                return bytes_of_all(read_apart<double>(buffers.q, count),
                                    read_apart<std::uint32_t>(buffers.triangles, count));
            }),
        use("count links",
            [](auto& used) {
                return bytes_of_all(std::vector<std::size_t>{used.count_links(small_grid(), directions())});
            }),
        use("crossings",
            [](auto& used) { return bytes_of_crossings(used.crossings(small_grid(), {.with_counts = true})); }),
        use("exact signs",
            [](auto& used) {
                return bytes_of_field(
                    used.compute(small_grid(), small_band().with_exact_signs(), outputs_of_uses).slab());
            }),
        use("rays",
            [](auto& used) {
                const std::vector<Vec3> origins = points_about(200), along(origins.size(), Vec3{0.3, 1, -0.2});
                std::vector<double> t(origins.size(), 7);
                std::vector<std::uint32_t> counts(origins.size(), 7);
                used.rays(origins, along, {}, {.t = t, .counts = counts});
                return bytes_of_all(t, counts);
            }),
        use("pairs of points",
            [](auto& used) {
                const std::vector<Vec3> from = points_about(200);
                const std::vector<Vec3> to(from.rbegin(), from.rend());
                std::vector<std::uint8_t> visible(from.size(), 7);
                used.visible(from, to, visible);
                return bytes_of_all(visible);
            }),
        {"plan of links",
         [] {
             const auto used = transform_of(mesh());
             const auto plan =
                 std::make_shared<LinkPlan>(used->plan_links(small_grid(), directions(), LinkBuffers::room));
             const auto buffers = std::make_shared<LinkBuffers>();
             return [=] {
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, buffers->targets(), {buffers->count()}, {}, &done);
                 wait_for(cl::Event(done));
                 return buffers->found();
             };
         }},
        {"update a plan of links",
         [] {
             const auto used = transform_of(mesh());
             const auto plan =
                 std::make_shared<LinkPlan>(used->plan_links(small_grid(), directions(), LinkBuffers::room));
             const auto buffers = std::make_shared<LinkBuffers>();
             return [=] {
                 used->set_positions(scaled(mesh(), 1.01).vertices());
                 plan->update(*used);
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, buffers->targets(), {buffers->count()}, {}, &done);
                 wait_for(cl::Event(done));
                 return buffers->found();
             };
         }},
        {"points of a scene", [] { return [bodies = scene()] { return query_of_scene(*bodies); }; }},
        {"points of a union", [] { return [bodies = scene(Surface::outer)] { return query_of_scene(*bodies); }; }},
        {"points of a scene that moves",
         [] {
             return [bodies = scene()] {
                 const std::vector<Pose> poses(4, Pose{.translation = {0.1, 0.2, 0.3}});
                 bodies->set_poses(poses);
                 return query_of_scene(*bodies);
             };
         }},
        {"field of a scene",
         [] {
             return [bodies = scene()] {
                 return bytes_of_field(bodies->compute(scene_grid(), Band::symmetric(0.5), outputs_of_uses).slab());
             };
         }},
        {"field of a union",
         [] {
             return [bodies = scene(Surface::outer)] {
                 return bytes_of_field(bodies->compute(scene_grid(), Band::symmetric(0.5), outputs_of_uses).slab());
             };
         }},
        {"outer surface",
         [] {
             return [] {
                 const DistanceTransform used(test_device(), mesh(), {.surface = Surface::outer});
                 return bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses).slab());
             };
         }},
        {"cut cells by kernels",
         [] {
             return [] {
                 std::vector<std::int32_t> cells(3 * CellBuffers::room, 7);
                 std::vector<double> volume(CellBuffers::room, 7);
                 std::size_t count = 0;
                 fractions(test_device(), surface(), small_grid(),
                           {.room = CellBuffers::room, .cells = cells, .volume = volume}, count);
                 return bytes_of_all(cells, volume, std::vector<std::size_t>{count});
             };
         }},
        {"plan of cut cells",
         [] {
             const auto plan =
                 std::make_shared<FractionPlan>(test_device(), surface(), small_grid(), CellBuffers::room);
             const auto buffers = std::make_shared<CellBuffers>();
             return [=] {
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, buffers->targets(), {buffers->count()}, {}, &done);
                 wait_for(cl::Event(done));
                 return buffers->found();
             };
         }},
        {"a plan of cut cells of moved vertices",
         [] {
             const auto plan =
                 std::make_shared<FractionPlan>(test_device(), surface(), small_grid(), CellBuffers::room);
             const auto buffers = std::make_shared<CellBuffers>();
             const std::vector<Vec3>& vertices = surface().mesh.vertices();
             const cl::Buffer moved = on_device(scaled(surface().mesh, 1.01).vertices());
             return [=, count = vertices.size()] {
                 cl_event done = nullptr;
                 plan->enqueue(nullptr, InputArray(moved(), ElementType::float64, count), buffers->targets(),
                               {buffers->count()}, {}, &done);
                 wait_for(cl::Event(done));
                 return buffers->found();
             };
         }},
        use("bytes of a part",
            [](auto& used) {
                const std::vector<std::byte> bytes = restricted(used).part_bytes();
                return field_of_part(DistanceTransform::from_part(test_device(), bytes));
            }),
        use("shared memory",
            [](auto& used) {
                std::vector<std::uint64_t> memory(used.prepared_bytes() / sizeof(std::uint64_t) + 16);
                std::span<std::byte> bytes = std::as_writable_bytes(std::span(memory));
                bytes = bytes.subspan((64 - reinterpret_cast<std::uintptr_t>(bytes.data()) % 64) % 64)
                            .first(used.prepared_bytes());
                used.share(bytes);
                return field_of_part(DistanceTransform::from_shared(test_device(), bytes));
            }),
    };
    return all;
}

}  // namespace clsdf::test

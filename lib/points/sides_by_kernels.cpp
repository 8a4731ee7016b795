#include "points/face_sides.hpp"

#include "launch/commands.hpp"
#include "launch/short_launches.hpp"
#include "side_shapes.h"

#include <algorithm>

namespace clsdf::points {

namespace {

// First estimates for a core: of the faces near a face, and of the crossings in front of one.
constexpr double seconds_per_face = 1e-5, seconds_per_front = 1e-5;

}  // namespace

FaceSides find_face_sides(const engine::DeviceTools& tools, const engine::PointFaces& mesh,
                          const engine::FittedTree& tree, const DeviceSignFaces& surface) {
    const engine::GeometryOnDevice& geometry = *mesh.geometry;
    const engine::DeviceTopology& topology = *geometry.topology;
    const std::size_t faces = mesh.count, vertices = topology.vertex_count();
    const auto count = static_cast<cl_uint>(faces);
    PointUnits units{{}, mesh.lattice.unit};
    std::copy(mesh.lattice.origin.begin(), mesh.lattice.origin.end(), units.origin);
    const auto lease = [&](std::size_t bytes) { return tools.pool->lease(bytes, "sides of faces"); };
    const device::BufferPool::Lease shapes = lease(faces * sizeof(SideShape)), met = lease(faces * sizeof(cl_uint)),
                                    above = lease(faces * sizeof(cl_uint)), best = lease(faces * sizeof(cl_uint)),
                                    chosen = lease(faces * sizeof(cl_uint)), of_roots = lease(faces * sizeof(cl_uint)),
                                    of_vertices = lease(3 * vertices * sizeof(cl_float));
    FaceSides result;
    result.sides = lease(faces * sizeof(cl_ushort));
    result.normals = std::make_shared<const device::BufferPool::Lease>(lease(18 * faces * sizeof(cl_float)));
    const cl::Buffer &positions = **geometry.positions, &triangles = *topology.names->triangles,
                     &edges = *topology.edges;
    const engine::DividedFaces& divided = *tree.divided;
    const engine::ShortLaunches short_launches(tools.context, {});
    const auto run = [&](const char* name, std::size_t items, const auto&... arguments) {
        device::LentKernel kernel = tools.kernel(tools.programs.point_signs, name);
        engine::launch(tools.queue(), kernel, {items}, arguments...);
    };
    device::guarded([&] {
        for (const auto* zeros : {&met, &above, &best, &chosen})
            tools.queue().enqueueFillBuffer(**zeros, cl_uint{0}, 0, faces * sizeof(cl_uint));
        run("side_shapes", faces, count, units, positions, triangles, *topology.starts, *shapes);
        short_launches.over(faces, seconds_per_face, [&](std::size_t begin, std::size_t end) {
            run("compare_faces", end - begin, static_cast<cl_uint>(begin), static_cast<cl_uint>(end), units,
                divided.tree, *tree.nodes, *divided.order, positions, triangles, *shapes, *met);
        });
        run("join_fronts", faces, count, edges, *shapes, *met, *above);
        run("find_best_fronts", faces, count, *shapes, *met, *above, *best);
        run("choose_fronts", faces, count, *shapes, *met, *best, *chosen);
        short_launches.over(faces, seconds_per_front, [&](std::size_t begin, std::size_t end) {
            run("cross_fronts", end - begin, static_cast<cl_uint>(begin), static_cast<cl_uint>(end), units,
                divided.tree, *tree.nodes, *divided.order, surface.faces, positions, *surface.positions, triangles,
                *shapes, *chosen, *of_roots);
        });
        run("tell_by_vertices", vertices, static_cast<cl_uint>(vertices), units, positions, triangles, *topology.starts,
            *topology.corners, edges, *shapes, *met, *of_vertices);
        run("write_sides", faces, count, *topology.order, triangles, edges, *shapes, *met, *of_roots, *of_vertices,
            *result.sides, **result.normals);
    });
    return result;
}

}  // namespace clsdf::points

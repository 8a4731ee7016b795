#include "transform/prepared_mesh.hpp"

#include "core/stopwatch.hpp"
#include "transform/layout_of.hpp"

#include <fmt/format.h>

#include <cmath>

namespace clsdf::transform {

namespace {

// Squares of distances stay far inside a float's range.
constexpr double farthest = 1e14;

void check_distance(const Mesh& mesh, const polyhedra::LatticeView& lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = (mesh.box().lower[axis] - lattice.origin[axis]) / lattice.unit;
        const double high = (mesh.box().upper[axis] - lattice.origin[axis]) / lattice.unit;
        if (!(std::abs(low) < farthest) || !(std::abs(high) < farthest))
            throw Error(ErrorCode::invalid_argument, fmt::format("{} reaches more than 1e14 voxels from the grid's "
                                                                 "origin on axis {}; use a larger spacing, or a grid "
                                                                 "near the mesh",
                                                                 mesh.name(), "xyz"[axis]));
    }
}

}  // namespace

PreparedMesh prepare_mesh(device::Context& context, const std::shared_ptr<device::BufferPool>& pool, const Mesh& mesh,
                          const polyhedra::LatticeView& lattice, const Layout& layout) {
    const Stopwatch watch;
    check_distance(mesh, lattice);
    const PolyhedronWidths widths = polyhedron_widths(layout);
    const polyhedra::LeanedFrusta frusta = polyhedra::leaned_frusta(mesh, lattice, widths.half_width, widths.slack);

    PreparedMesh prepared;
    prepared.polyhedron_count = frusta.polyhedra.size();
    prepared.saddle_vertices = frusta.saddle_vertices;
    prepared.point_sites = frusta.point_sites;
    prepared.boxes = frusta.boxes;
    const std::size_t polyhedron_bytes = frusta.polyhedra.size() * sizeof(Polyhedron);
    const std::size_t triangle_bytes = mesh.triangles().size() * sizeof(Triangle);
    prepared.polyhedra = pool->lease(polyhedron_bytes, "polyhedra");
    prepared.triangles = pool->lease(triangle_bytes, "triangles");
    device::guarded([&] {
        const cl::CommandQueue& queue = context.queue();
        queue.enqueueWriteBuffer(*prepared.polyhedra, CL_TRUE, 0, polyhedron_bytes, frusta.polyhedra.data());
        queue.enqueueWriteBuffer(*prepared.triangles, CL_TRUE, 0, triangle_bytes, mesh.triangles().data());
    });
    prepared.seconds = watch.seconds();
    return prepared;
}

}  // namespace clsdf::transform

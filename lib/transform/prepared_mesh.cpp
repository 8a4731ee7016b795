#include "transform/prepared_mesh.hpp"

#include "core/stopwatch.hpp"
#include "device/host_filling.hpp"
#include "polyhedra/leaned_frusta.hpp"
#include "slices/leaned_pieces.hpp"
#include "slices/mauch_pieces.hpp"
#include "slices/peikert_sigg_pieces.hpp"
#include "transform/layout_of.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

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

/// No sample is farther from the mesh than from its box's farthest point.
double farthest_distance(const Mesh& mesh, const Grid& grid, double unit) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = grid.origin[axis] + static_cast<double>(grid.first[axis]) * grid.spacing[axis];
        const double high = low + static_cast<double>(grid.size[axis] - 1) * grid.spacing[axis];
        const double side = std::max(mesh.box().upper[axis] - low, high - mesh.box().lower[axis]) / unit;
        squared += side * side;
    }
    return std::sqrt(squared);
}

/// A slice has no bounds of its own for the distance as bricks have, so that an infinite band ends where the grid does.
PolyhedronWidths widths_for_slices(const Mesh& mesh, const Grid& grid, const Layout& layout) {
    PolyhedronWidths widths = polyhedron_widths(layout);
    if (std::isfinite(layout.outside_squared) && std::isfinite(layout.inside_squared)) return widths;
    return polyhedron_widths(farthest_distance(mesh, grid, static_cast<double>(layout.unit)));
}

device::BufferPool::Lease upload(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                                 const void* values, std::size_t bytes, const char* purpose) {
    auto lease = pool->lease(bytes, purpose);
    if (bytes > 0) device::guarded([&] { context.queue().enqueueWriteBuffer(*lease, CL_TRUE, 0, bytes, values); });
    return lease;
}

PreparedPieces prepare_pieces(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                              const slices::ConvexPieces& pieces) {
    PreparedPieces prepared;
    prepared.pieces = upload(context, pool, pieces.pieces.data(), pieces.pieces.size() * sizeof(Piece), "pieces");
    prepared.planes =
        upload(context, pool, pieces.planes.data(), pieces.planes.size() * sizeof(PiecePlane), "planes of the pieces");
    prepared.slices.reserve(pieces.pieces.size());
    for (std::size_t i = 0; i < pieces.pieces.size(); ++i)
        prepared.slices.push_back({pieces.pieces[i].slice_begin, pieces.pieces[i].slice_end, pieces.costs[i]});
    return prepared;
}

}  // namespace

std::size_t PreparedMesh::device_bytes() const {
    return polyhedra.bytes() + (pieces ? pieces->pieces.bytes() + pieces->planes.bytes() : 0);
}

PreparedMesh prepare_mesh(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                          ScratchMemory& scratch, const Mesh& mesh, const Grid& grid, const Layout& layout,
                          const TransformOptions& options, Scan scan) {
    const Stopwatch watch;
    const polyhedra::LatticeView lattice = lattice_of(grid);
    check_distance(mesh, lattice);
    const PolyhedronWidths widths =
        scan == Scan::slices ? widths_for_slices(mesh, grid, layout) : polyhedron_widths(layout);

    PreparedMesh prepared;
    const auto upload_polyhedra = [&](std::span<const Polyhedron> records) {
        prepared.record_count = records.size();
        prepared.polyhedron_count = records.size();
        prepared.polyhedra = upload(context, pool, records.data(), records.size_bytes(), "polyhedra");
    };
    if (options.polyhedra == Polyhedra::peikert_sigg) {
        const slices::PeikertSiggPieces paper =
            slices::peikert_sigg_pieces(mesh, lattice, widths.half_width, options.close_gaps, layout);
        prepared.closed_gaps = paper.closed_gaps;
        upload_polyhedra(paper.polyhedra);
        prepared.pieces = prepare_pieces(context, pool, paper.pieces);
    } else if (options.polyhedra == Polyhedra::mauch) {
        const slices::MauchPieces mauch = slices::mauch_pieces(mesh, lattice, widths.half_width, layout);
        upload_polyhedra(mauch.polyhedra);
        prepared.polyhedron_count = mauch.count();
        prepared.boxes = mauch.boxes;
        prepared.pieces = prepare_pieces(context, pool, mauch.pieces);
    } else {
        std::span<Polyhedron> records;
        std::unique_ptr<device::HostFilling> filling;
        const auto memory = [&](std::size_t count) {
            const std::size_t bytes = count * sizeof(Polyhedron);
            auto larger = std::make_unique<device::HostFilling>(context, pool, bytes, "polyhedra");
            const std::span<Polyhedron> filled(static_cast<Polyhedron*>(larger->memory()), count);
            std::copy(records.begin(), records.end(), filled.begin());
            filling = std::move(larger);
            return records = filled;
        };
        ScratchMemory::Computation computation(scratch);
        const polyhedra::LeanedCounts counts =
            polyhedra::leaned_frusta(mesh, lattice, widths.half_width, widths.slack, memory, &scratch);
        computation.succeed();
        prepared.saddle_vertices = counts.saddle_vertices;
        prepared.point_sites = counts.point_sites;
        prepared.boxes = counts.boxes;
        prepared.record_count = prepared.polyhedron_count = counts.records;
        records = records.first(counts.records);
        if (scan == Scan::slices)
            prepared.pieces =
                prepare_pieces(context, pool, slices::leaned_pieces(records, widths.half_width, widths.slack, layout));
        prepared.polyhedra = filling->finish();
    }
    prepared.seconds = watch.seconds();
    return prepared;
}

}  // namespace clsdf::transform

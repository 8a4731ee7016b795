#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "coarse.h"
#include "device/buffer_pool.hpp"
#include "layout.h"
#include "polyhedra/cluster_index.hpp"
#include "polyhedra/records.hpp"
#include "slices/convex_pieces.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace clsdf::transform {

/// The convex pieces of the polyhedra, for the scan by slices.
struct PreparedPieces {
    /// What the host keeps of a piece.
    struct Slices {
        std::int32_t begin = 0;
        std::int32_t end = 0;
        slices::PieceCost cost;
    };

    device::BufferPool::Lease pieces;
    device::BufferPool::Lease planes;
    std::vector<Slices> slices;  ///< of each piece
};

/// A fixed sample of the surface's points, in a lattice's units, that distances are bounded with.
using SurfacePoints = std::vector<SurfacePoint>;

/// Polyhedra on the device, as a lattice sees them: those of the whole mesh, or of what is near a box.
struct PreparedMesh {
    device::BufferPool::Lease polyhedra;   ///< Polyhedron: faces in Morton order, in whole groups (the last face is
                                           ///< repeated), then point sites
    std::optional<PreparedPieces> pieces;  ///< for the scan by slices
    std::size_t record_count = 0;
    std::size_t triangle_count = 0;    ///< of the mesh
    std::size_t polyhedron_count = 0;  ///< of the whole mesh; of Mauch's kind more than records
    std::size_t saddle_vertices = 0;
    std::size_t point_sites = 0;
    std::size_t closed_gaps = 0;
    std::size_t boxes = 0;

    std::size_t device_bytes() const;
};

/// Frusta, and their records for a lattice: made in one pass over the mesh.
struct FirstGeometry {
    polyhedra::Frusta frusta;
    PreparedMesh records;
};
FirstGeometry first_geometry(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                             const polyhedra::MeshTopology& topology, const Mesh& mesh,
                             const polyhedra::LatticeView& lattice);

/// The records of the whole mesh.
PreparedMesh all_records(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                         const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                         const polyhedra::LatticeView& lattice);

/// The records of what is near a box.
PreparedMesh near_records(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                          const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                          const polyhedra::LatticeView& lattice, const polyhedra::NearRecords& near);

SurfacePoints surface_points(const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                             const polyhedra::LatticeView& lattice);

/// Throws Error(invalid_argument) if squares of distances would leave a float's range.
void check_distance(const Mesh& mesh, const polyhedra::LatticeView& lattice);

/// The records and pieces of a scan by slices. Leaned frusta and their records are given.
PreparedMesh records_with_pieces(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                                 const Mesh& mesh, const Grid& grid, const Layout& layout,
                                 const TransformOptions& options, const polyhedra::MeshTopology* topology,
                                 const polyhedra::Frusta* frusta);

}  // namespace clsdf::transform

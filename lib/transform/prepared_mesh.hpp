#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "core/scratch_memory.hpp"
#include "device/buffer_pool.hpp"
#include "layout.h"
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

/// A mesh on the device, as seen from one grid with one band: what all parts of the grid share.
struct PreparedMesh {
    device::BufferPool::Lease polyhedra;
    std::optional<PreparedPieces> pieces;  ///< for the scan by slices
    std::size_t record_count = 0;
    std::size_t polyhedron_count = 0;  ///< of Mauch's kind more than records
    std::size_t saddle_vertices = 0;
    std::size_t point_sites = 0;
    std::size_t closed_gaps = 0;
    std::size_t boxes = 0;
    double seconds = 0;

    std::size_t device_bytes() const;
};

/// `scan` is that of the options, but never automatic.
PreparedMesh prepare_mesh(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                          ScratchMemory& scratch, const Mesh& mesh, const Grid& grid, const Layout& layout,
                          const TransformOptions& options, Scan scan);

}  // namespace clsdf::transform

#pragma once

#include "transform/prepared_mesh.hpp"

#include <span>
#include <vector>

namespace clsdf::transform {

/// Slices that are computed together, because there is memory for their keys and active pieces.
struct SliceChunk {
    std::int32_t begin;  ///< slices [begin, end) of the lattice
    std::int32_t end;
    std::size_t active_begin;  ///< (piece, slice) in the order of slices: [active_begin, active_end)
    std::size_t active_end;
};

/// Entries [begin, end) of a chunk's active list, counted from its first.
struct SliceLaunch {
    std::size_t chunk;
    std::int32_t pass;
    std::size_t begin;
    std::size_t end;
    double fraction_before;  ///< of the work
};

struct SliceSchedule {
    std::vector<SliceChunk> chunks;
    std::vector<SliceLaunch> launches;  ///< of each chunk at least one a pass
    std::size_t most_slices = 0;        ///< of a chunk
    std::size_t most_active = 0;
};

struct SliceLimits {
    std::size_t slices_at_once;  ///< at least 1
    std::size_t active_at_once;  ///< a single slice may exceed it
    double cost_per_launch;      ///< in distances of a sample; a single piece may exceed it
    std::int32_t passes;
};

/// Of a piece in a slice, in distances of a sample.
double cost_of(const slices::PieceCost& piece);

/// Divides slices [first, first + count) of the lattice.
SliceSchedule schedule_slices(std::span<const PreparedPieces::Slices> pieces, std::int32_t first, std::int32_t count,
                              const SliceLimits& limits);

}  // namespace clsdf::transform

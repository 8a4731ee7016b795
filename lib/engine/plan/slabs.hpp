#pragma once

#include <clsdf/grid.hpp>

#include "device/context.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace clsdf::engine {

/// How a grid is divided along z. Slabs end at coarse bricks if possible, because each slab makes its own lists.
/// Otherwise they end at bricks, so that no sample is computed twice. Any division gives the same bytes.
struct SlabLimits {
    std::size_t preferred;  ///< bytes of distances: slabs of whole coarse bricks up to it, one of them at least,
    std::size_t tolerated;  ///< as long as that takes no more than this; whole bricks else
    std::size_t largest;    ///< never more bytes of any output, but a slice
};

/// For fields in host memory: on a processor as few slabs as possible; on other devices enough that one is read while
/// another is computed.
SlabLimits limits_of(const device::Context::Capabilities& device);

/// For fields that are handed on slab by slab: 64 MiB of samples, or 32 slices if they take at most 256 MiB.
SlabLimits stream_limits_of(const device::Context::Capabilities& device);

/// Throws Error(invalid_argument) for a grid that kernels cannot compute, see layout_of().
void check_grid(const Grid& grid);

/// Parts of a grid that was checked, in the order of z, which together are the grid. widest: bytes that one sample has
/// in the largest of the outputs.
std::vector<Grid> slabs_of(const Grid& grid, const SlabLimits& limits, std::size_t widest = sizeof(float));

/// The same of a sparse field: its sign bits take most of the memory.
std::vector<Grid> sparse_slabs_of(const Grid& grid);

/// Whether a slab has brick boundaries within.
bool is_divisible(const Grid& slab);

/// Divides it at the brick boundary, or coarse brick boundary, next to its middle; it must be divisible.
std::pair<Grid, Grid> halves_of(const Grid& slab);

}  // namespace clsdf::engine

#include "plan/slabs.hpp"

#include "lattice/layout_of.hpp"
#include "layout.h"

#include <algorithm>

namespace clsdf::engine {

namespace {

/// The distance of slice `z` of the grid from the last multiple of `side` on the lattice.
std::int64_t behind_boundary(const Grid& grid, std::int64_t z, std::int64_t side) {
    return ((grid.first[2] + z) % side + side) % side;
}

constexpr std::size_t mebibyte = std::size_t{1} << 20;

/// Two slabs of two outputs, and as much again for everything else.
std::size_t largest_of(const device::Context::Capabilities& device) {
    return std::min(device.largest_allocation, device.memory / 8);
}

std::size_t samples_of_slice(const Grid& grid) {
    return static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
}

Grid slices_of(const Grid& grid, std::int64_t begin, std::int64_t end) {
    return grid.part({0, 0, begin}, {grid.size[0], grid.size[1], end - begin});
}

/// The most slices of a slab.
std::int64_t most_slices(const Grid& grid, const SlabLimits& limits, std::size_t widest) {
    const std::size_t slice = samples_of_slice(grid) * sizeof(float);
    const std::size_t coarse = CLSDF_COARSE * slice;
    const std::size_t wished = coarse <= limits.tolerated ? std::max(limits.preferred, coarse) : limits.tolerated;
    const std::size_t brick = CLSDF_BRICK * slice;
    const std::size_t slices =
        std::min(std::max(wished, brick) / slice, limits.largest / (samples_of_slice(grid) * widest));
    // Sign bits and their counts take whole bricks; of a grid that is thin along x they outweigh the field.
    constexpr std::size_t sign_limit = 96 * mebibyte;
    return static_cast<std::int64_t>(
        std::min(slices, std::max<std::size_t>(sign_limit / sign_bytes_of_slice(grid), CLSDF_BRICK)));
}

}  // namespace

SlabLimits limits_of(const device::Context::Capabilities& device) {
    if (device.is_processor) return {device.largest_allocation, device.largest_allocation, device.largest_allocation};
    return {256 * mebibyte, 1024 * mebibyte, largest_of(device)};
}

SlabLimits stream_limits_of(const device::Context::Capabilities& device) {
    return {64 * mebibyte, 256 * mebibyte, largest_of(device)};
}

void check_grid(const Grid& grid) {
    layout_of(grid, Band::signs_only(), SignRule::none);
}

namespace {

std::vector<Grid> slabs_of(const Grid& grid, std::int64_t most) {
    if (most >= grid.size[2]) return {grid};
    std::vector<Grid> slabs;
    for (std::int64_t begin = 0; begin < grid.size[2];) {
        std::int64_t end = std::min(grid.size[2], begin + std::max<std::int64_t>(most, 1));
        for (const std::int64_t side : {std::int64_t{CLSDF_COARSE}, std::int64_t{CLSDF_BRICK}}) {
            const std::int64_t behind = behind_boundary(grid, end, side);
            if (end < grid.size[2] && end - behind > begin) {
                end -= behind;
                break;
            }
        }
        slabs.push_back(slices_of(grid, begin, end));
        begin = end;
    }
    return slabs;
}

}  // namespace

std::vector<Grid> slabs_of(const Grid& grid, const SlabLimits& limits, std::size_t widest) {
    return slabs_of(grid, most_slices(grid, limits, widest));
}

std::vector<Grid> sparse_slabs_of(const Grid& grid) {
    constexpr std::size_t preferred = 32 * mebibyte, tolerated = 384 * mebibyte;
    const std::size_t slice = sign_bytes_of_slice(grid), coarse = CLSDF_COARSE * slice;
    const std::size_t wished = coarse <= tolerated ? std::max(preferred, coarse) : tolerated;
    return slabs_of(grid, static_cast<std::int64_t>(std::max<std::size_t>(wished / slice, CLSDF_BRICK)));
}

bool is_divisible(const Grid& slab) {
    // The first slice of the last slice's brick is not the slab's first.
    return slab.size[2] - 1 > behind_boundary(slab, slab.size[2] - 1, CLSDF_BRICK);
}

std::pair<Grid, Grid> halves_of(const Grid& slab) {
    const std::int64_t size = slab.size[2];
    const std::int64_t half = (size + 1) / 2;
    std::int64_t middle = 0;
    for (const std::int64_t side : {std::int64_t{CLSDF_BRICK}, std::int64_t{CLSDF_COARSE}}) {
        const std::int64_t below = half - behind_boundary(slab, half, side);
        for (const std::int64_t boundary : {below + side, below})
            if (boundary > 0 && boundary < size) middle = boundary;
    }
    return {slices_of(slab, 0, middle), slices_of(slab, middle, size)};
}

}  // namespace clsdf::engine

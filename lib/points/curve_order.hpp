#pragma once

#include "core/large_memory.hpp"

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>

namespace clsdf::points {

/// The points' indices along a Hilbert curve through their own box, as far as it lies in `most`, with 2^10 cells along
/// its longest side; points outside lie in the outermost cells. Neighbours in the list are neighbours in space. All
/// coordinates are finite; there are fewer than 2^32 points.
UninitializedVector<std::uint32_t> curve_order(std::span<const Vec3> points, const Box& most);

}  // namespace clsdf::points

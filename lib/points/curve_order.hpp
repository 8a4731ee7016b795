#pragma once

#include <clsdf/mesh.hpp>

#include "core/uninitialized_vector.hpp"

#include <cstdint>
#include <span>

namespace clsdf::points {

/// The points' indices along a Morton curve through the box, 2^21 cells along its longest side; points outside it lie
/// in its outermost cells. Neighbours in the list are neighbours in space. All coordinates are finite.
UninitializedVector<std::uint32_t> curve_order(std::span<const Vec3> points, const Box& box);

}  // namespace clsdf::points

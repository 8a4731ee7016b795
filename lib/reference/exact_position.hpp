#pragma once

#include <clsdf/grid.hpp>

#include <cmath>

namespace clsdf::reference {

/// A point known beyond double precision: the sum of two doubles on each axis. `tail` is what rounding `head` lost.
struct ExactPosition {
    Vec3 head{};
    Vec3 tail{};

    /// The largest distance on an axis between the point and the double nearest to it.
    double rounding() const { return std::fmax(std::fabs(tail[0]), std::fmax(std::fabs(tail[1]), std::fabs(tail[2]))); }
};

/// Position of sample (i, j, k) of the grid's block: origin + (first + index) * spacing, a real number, to 106 bits.
inline ExactPosition exact_position(const Grid& grid, const Index3& index) {
    ExactPosition position;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto steps = static_cast<double>(grid.first[axis] + index[axis]);
        const double product = steps * grid.spacing[axis];
        const double product_tail = std::fma(steps, grid.spacing[axis], -product);
        const double origin = grid.origin[axis];
        const double sum = origin + product;
        const double product_part = sum - origin;
        const double sum_tail = (origin - (sum - product_part)) + (product - product_part);
        const double tail = sum_tail + product_tail;
        // Renormalised, so that the head is the double nearest to the sample.
        position.head[axis] = sum + tail;
        position.tail[axis] = tail - (position.head[axis] - sum);
    }
    return position;
}

}  // namespace clsdf::reference

#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <array>
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

/// A triangle by its corners.
using Corners = std::array<Vec3, 3>;

/// The intersection of the line parallel to x through (y, z) with a triangle, in exact arithmetic.
struct LineMeeting {
    /// 1 or -1: the line crosses the triangle, whose normal has this sign along x. Points on edges and vertices of the
    /// projection are decided by moving the line by (+e, +e^2) in (y, z), so that a closed surface is crossed
    /// consistently and triangles without a projected area never are. 0: the line does not cross.
    int crossing = 0;
    /// The line, not moved, meets the projection of the closed triangle. If the projection has no area: it meets the
    /// straight line that contains the projection.
    bool touches = false;
    /// The sign of the projected area.
    int facing = 0;
};

LineMeeting meet_line(const Corners& triangle, double y, double z);

/// The side of a triangle's plane that a point lies on, seen along x for a triangle of that facing (not 0): -1 before
/// the plane, 0 on it, 1 beyond it.
int side_along_x(const Corners& triangle, int facing, const Vec3& point);

/// Whether the point lies on the closed triangle, which may be degenerate.
bool lies_on(const Corners& triangle, const Vec3& point);

}  // namespace clsdf::reference

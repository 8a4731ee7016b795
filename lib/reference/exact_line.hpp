#pragma once

#include <clsdf/mesh.hpp>

#include <array>

namespace clsdf::reference {

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

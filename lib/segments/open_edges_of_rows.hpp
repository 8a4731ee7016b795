#pragma once

#include "mesh/segment_crossings.hpp"
#include "surface/open_edges.hpp"
#include "tree/crossed_faces.hpp"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

/// What open edges add to the winding number of a point in the eight looks (kernels/common/segment_crossings.h), beside
/// what they add in the first one, which is that of FilmTree::look(). A point sees that part jump where the row towards
/// -x meets an open edge, and there only; the faces at the edge jump against it.
namespace clsdf::segments {

/// Calls visit(looks, change) for an open edge from a to b that the row along x through (y, z) meets at an x below the
/// point's. Looks move the point by (e, e^2, e^3). From there a path goes along y to greater y, and at last along z to
/// where that of the first look ends. It meets the edge's halves that lie on the side of z to which the look has moved
/// the point, if it was moved to lesser y; and then level ones at greater y. To the left of an edge, seen against x,
/// the part is one more.
template <typename Visit>
void visit_looks_of_edge(const Vec3& a, const Vec3& b, double y, double z, const Visit& visit) {
    constexpr std::uint32_t upper_of_lesser_y = 0x0C, lower_of_lesser_y = 0xC0, lower = 0xF0;
    const std::size_t axis = a[2] != b[2] ? 2 : 1;
    const bool is_forward = b[axis] > a[axis];
    for (const Vec3& end : {a, b})
        if (axis == 2 && end[2] != z)
            visit(end[2] > z ? upper_of_lesser_y : lower_of_lesser_y, is_forward ? 1 : -1);
        else if (axis == 1 && end[1] > y)
            visit(lower, is_forward ? -1 : 1);
}

/// Calls visit(a, b) for all open edges, in units.
template <typename Visit>
void for_each_open_edge(const OpenBoundary& boundary, double per_unit, const Visit& visit) {
    for (std::size_t loop = 0; loop + 1 < boundary.begins.size(); ++loop) {
        const std::size_t begin = boundary.begins[loop], end = boundary.begins[loop + 1];
        for (std::size_t i = begin; i < end; ++i)
            visit(engine::scaled(boundary.corners[i], per_unit),
                  engine::scaled(boundary.corners[i + 1 < end ? i + 1 : begin], per_unit));
    }
}

/// Whether the row along x through (y, z) meets an edge that is not parallel to it.
inline bool is_on_row(const Vec3& a, const Vec3& b, double y, double z) {
    const auto is_between = [](double from, double to, double x) {
        return x >= std::min(from, to) && x <= std::max(from, to);
    };
    return is_between(a[1], b[1], y) && is_between(a[2], b[2], z) && (a[1] != b[1] || a[2] != b[2]) &&
           crossing::orientation_in_plane(a[1], a[2], b[1], b[2], y, z) == 0;
}
/// Whether it meets the edge at a lesser x than the point's.
inline bool is_beyond(const Vec3& a, const Vec3& b, const Vec3& point) {
    const std::size_t axis = a[2] != b[2] ? 2 : 1;
    return crossing::orientation_in_plane(a[0], a[axis], b[0], b[axis], point[0], point[axis]) ==
           (b[axis] > a[axis] ? -1 : 1);
}

}  // namespace clsdf::segments

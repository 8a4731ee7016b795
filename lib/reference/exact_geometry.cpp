#include "exact_geometry.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>

namespace clsdf::reference {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point2 = Kernel::Point_2;
using Point3 = Kernel::Point_3;

Point3 point3(const Vec3& point) {
    return {point[0], point[1], point[2]};
}

/// Without the coordinate `axis`; the others keep their cyclic order.
Point2 project(const Vec3& point, std::size_t axis) {
    return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
}

int turn(const Point2& a, const Point2& b, const Point2& c) {
    return static_cast<int>(CGAL::orientation(a, b, c));
}

int side_of_plane(const Corners& triangle, const Vec3& point) {
    return static_cast<int>(
        CGAL::orientation(point3(triangle[0]), point3(triangle[1]), point3(triangle[2]), point3(point)));
}

/// The sign of turn(from, to, point) once a point on the line through `from` and `to` is moved by (+e, +e^2).
int moved_turn(int sign, const Point2& from, const Point2& to) {
    if (sign != 0) {
        return sign;
    }
    if (from.y() != to.y()) {
        return to.y() < from.y() ? 1 : -1;
    }
    return to.x() > from.x() ? 1 : (to.x() < from.x() ? -1 : 0);
}

bool between(double value, double one, double other) {
    return std::min(one, other) <= value && value <= std::max(one, other);
}

bool lies_on_segment(const Vec3& from, const Vec3& to, const Vec3& point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!between(point[axis], from[axis], to[axis])) {
            return false;
        }
    }
    return CGAL::collinear(point3(from), point3(to), point3(point));
}

}  // namespace

LineMeeting meet_line(const Corners& triangle, double y, double z) {
    const Point2 line(y, z);
    const Point2 corners[3] = {project(triangle[0], 0), project(triangle[1], 0), project(triangle[2], 0)};
    LineMeeting meeting;
    meeting.facing = turn(corners[0], corners[1], corners[2]);
    bool crosses = meeting.facing != 0;
    meeting.touches = true;
    for (std::size_t i = 0; i < 3; ++i) {
        const Point2& from = corners[i];
        const Point2& to = corners[(i + 1) % 3];
        const int sign = turn(from, to, line);
        if (meeting.facing == 0 ? sign != 0 : sign == -meeting.facing) {
            return {0, false, meeting.facing};
        }
        crosses = crosses && moved_turn(sign, from, to) == meeting.facing;
    }
    meeting.crossing = crosses ? meeting.facing : 0;
    return meeting;
}

int side_along_x(const Corners& triangle, int facing, const Vec3& point) {
    return side_of_plane(triangle, point) * facing;
}

bool lies_on(const Corners& triangle, const Vec3& point) {
    if (side_of_plane(triangle, point) != 0) {
        return false;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Point2 corners[3] = {project(triangle[0], axis), project(triangle[1], axis), project(triangle[2], axis)};
        const int facing = turn(corners[0], corners[1], corners[2]);
        if (facing == 0) {
            continue;
        }
        const Point2 projected = project(point, axis);
        return std::ranges::all_of(std::array{0, 1, 2}, [&](int i) {
            const auto k = static_cast<std::size_t>(i);
            return turn(corners[k], corners[(k + 1) % 3], projected) != -facing;
        });
    }
    // Collinear: two of the edges cover the third.
    return lies_on_segment(triangle[0], triangle[1], point) || lies_on_segment(triangle[1], triangle[2], point);
}

}  // namespace clsdf::reference

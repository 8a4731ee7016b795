#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/predicates.hpp"

#include <cstddef>

namespace clsdf {

/// On which side of the line a -> b the point lies, seen along the axis before `first`: -1, 0 or 1.
inline int side_of_line(const Vec3& a, const Vec3& b, const Vec3& p, std::size_t first, std::size_t second) {
    return orientation({a[first], a[second]}, {b[first], b[second]}, {p[first], p[second]});
}

/// The same in (y, z), or another pair of axes, for the point displaced by (e, e^2) there, e positive and arbitrarily
/// small; 0 only if a and b coincide there.
inline int displaced_side(const Vec3& a, const Vec3& b, const Vec3& p, std::size_t first = 1, std::size_t second = 2) {
    if (const int side = side_of_line(a, b, p, first, second); side != 0) return side;
    if (a[second] != b[second]) return b[second] < a[second] ? 1 : -1;
    return a[first] == b[first] ? 0 : b[first] > a[first] ? 1 : -1;
}

/// The side of all edges of the face a, b, c on which the displaced point lies: then the line along x through it meets
/// the face. 0 if it does not.
inline int side_of_edges(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    const int side = displaced_side(a, b, p);
    return side != 0 && displaced_side(b, c, p) == side && displaced_side(c, a, p) == side ? side : 0;
}

/// How the ray towards -x from a point crosses the wall below the edge a -> b of a rim, down to the floor: what the
/// wall adds to the winding number. The faces lie left of the edge, seen from above. The point is displaced by (e, e^2,
/// e^3) in (y, z, x), so a point on a wall or on the floor has a side, too.
inline int crossing_of_wall(const Vec3& a, const Vec3& b, double floor, const Vec3& p) {
    const bool is_ascending = b[1] > p[1];  // in y, if the ray's y lies between
    if ((a[1] > p[1]) == is_ascending || p[2] < floor) return 0;
    const int direction = is_ascending ? 1 : -1;
    const bool is_below_edge = displaced_side(a, b, p) != direction,
               is_beyond = displaced_side(a, b, p, 1, 0) == direction;
    return is_below_edge && is_beyond ? -direction : 0;
}

}  // namespace clsdf

#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/predicates.hpp"

#include <cstddef>

namespace clsdf {

/// On which side of the line a -> b the point lies, seen along the axis before `first`: -1, 0 or 1.
inline int side_of_line(const Vec3& a, const Vec3& b, const Vec3& p, std::size_t first, std::size_t second) {
    return orientation({a[first], a[second]}, {b[first], b[second]}, {p[first], p[second]});
}

/// The same in (y, z) for the point displaced by (e, e^2), e positive and arbitrarily small; 0 only if a and b
/// coincide there.
inline int displaced_side(const Vec3& a, const Vec3& b, const Vec3& p) {
    if (const int side = side_of_line(a, b, p, 1, 2); side != 0) return side;
    if (a[2] != b[2]) return b[2] < a[2] ? 1 : -1;
    return a[1] == b[1] ? 0 : b[1] > a[1] ? 1 : -1;
}

/// The side of all edges of the face a, b, c on which the displaced point lies: then the line along x through it meets
/// the face. 0 if it does not.
inline int side_of_edges(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    const int side = displaced_side(a, b, p);
    return side != 0 && displaced_side(b, c, p) == side && displaced_side(c, a, p) == side ? side : 0;
}

}  // namespace clsdf

#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <cmath>

namespace clsdf::polyhedra {

/// Two faces whose inward directions differ by less than this angle are folded onto each other.
inline constexpr double fold_angle = 1e-6;

/// `squared_apart`: the square of the distance of their unit inward directions at the edge.
inline bool folded(double squared_apart) {
    return squared_apart < fold_angle * fold_angle;
}

/// side_of_plane() where the faces' frames tell, else 0. `sine`: of the second face's inward direction, above the first
/// face's plane.
inline int certain_side(const TriangleFrame& first, const TriangleFrame& second, double sine) {
    if (first.is_box || second.is_box || !(std::abs(sine) > first.turn + second.turn)) return 0;
    return sine > 0 ? 1 : -1;
}

/// On which side of the first face's plane the second face's opposite vertex lies: 1 above (the edge is concave seen
/// from above), -1 below, 0 in it. Exact for the coordinates as given (CGAL's predicate, behind a filter). `first` and
/// `second` are the faces' own edges.
int side_of_plane(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const TriangleFrame> frames,
                  const Corner& first, const Corner& second);

}  // namespace clsdf::polyhedra

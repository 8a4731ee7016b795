#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

namespace clsdf::polyhedra {

/// Two faces whose inward directions differ by less than this angle are folded onto each other.
inline constexpr double fold_angle = 1e-6;

/// The tangent of half the angle by which the wedge between two faces exceeds a straight one, seen from the side where
/// it does; both faces have the same. `first` and `second` are their unit inward directions at the edge.
inline double half_wedge_slope(const Vector& first, const Vector& second) {
    return (first + second).norm() / (first - second).norm();
}

inline bool folded(const Vector& first, const Vector& second) {
    return (first - second).squaredNorm() < fold_angle * fold_angle;
}

/// On which side of the first face's plane the second face's opposite vertex lies: 1 above (the edge is concave seen
/// from above), -1 below, 0 in it. Exact for the coordinates as given (CGAL's predicate, behind a filter). `first` and
/// `second` are the faces' own edges.
int side_of_plane(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const TriangleFrame> frames,
                  const Corner& first, const Corner& second);

}  // namespace clsdf::polyhedra

#pragma once

#include "tree/wide_tree.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace clsdf::points {

/// The surface's crossings on a way from outside the mesh to a point.
struct Crossings {
    int winding = 0;  ///< the winding number of a surface that is balanced
    int count = 0;    ///< even or odd, as many of them as of any other way if the surface is closed

    bool are_inside(SignRule rule) const { return rule == SignRule::parity ? count % 2 != 0 : winding != 0; }
};

/// Crossings of a point that is not on the surface, given in the caller's coordinates and in units. Exact for the
/// caller's coordinates.
Crossings count_crossings(const engine::SearchedMesh& searched, const Vec3& point, const Vec3& in_units);

/// The generalised winding number of a point, given in the caller's coordinates. boundary: the open edges, or empty.
double winding_number(const engine::SearchedMesh& searched, const OpenBoundary& boundary, const Vec3& point);
/// That of all points of a ball without surface, rounded to an integer, a half up; nothing if it may not be the same.
/// The open edges count: PointMesh::film is not null. radius: in units.
std::optional<int> rounded_winding_number(const engine::SearchedMesh& searched, const Vec3& centre, double radius);
/// The same of a point.
int rounded_winding_number(const engine::SearchedMesh& searched, const Vec3& point);
/// Whether a point is inside by the rule `below`: PointMesh::walls is not null.
bool is_inside_walls(const engine::SearchedMesh& searched, const Vec3& point);

/// Points whose nearest faces are known, in an order in which neighbours are near each other.
struct LocatedPoints {
    std::span<const Vec3> callers;         ///< the caller's coordinates, in the caller's order
    std::span<const std::uint32_t> order;  ///< the caller's index of each point; of all that follows the order
    std::span<const double> squared;       ///< of the distance in units, or a lower bound of it above 0
};

/// Sets CLSDF_POINT_INSIDE, _OUTSIDE or _ON_SURFACE for each that is CLSDF_POINT_UNDECIDED, exactly for the caller's
/// coordinates. Without a sign no point is inside.
///
/// Two points have the same sign if a ball around one of them holds the other and does not reach the surface. For every
/// other point, crossings with the surface are counted: on the way from a point nearby, or on a ray along x. If open
/// edges count, the ball does not reach the film or the walls that close the surface either, and the ray is one towards
/// -x.
void find_signs(const engine::SearchedMesh& searched, SignRule rule, const LocatedPoints& points,
                std::span<std::uint8_t> signs);

}  // namespace clsdf::points

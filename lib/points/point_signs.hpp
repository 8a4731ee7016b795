#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "points/point_mesh.hpp"

#include <cstdint>
#include <span>

namespace clsdf::points {

/// Points whose nearest faces are known, in an order in which neighbours are near each other.
struct LocatedPoints {
    std::span<const Vec3> callers;         ///< the caller's coordinates, in the caller's order
    std::span<const std::uint32_t> order;  ///< the caller's index of each point; of all that follows the order
    std::span<const Vec3> in_units;        ///< of PointMesh::lattice
    std::span<const double> squared;       ///< of the distance in units, or a lower bound of it above 0
};

/// Sets CLSDF_POINT_INSIDE, _OUTSIDE or _ON_SURFACE for each, exactly for the caller's coordinates. Without a sign no
/// point is inside.
///
/// Two points have the same sign if a ball around one of them holds the other and does not reach the surface. For every
/// other point, crossings with the surface are counted: on the way from a point nearby, or on a ray along x.
void find_signs(const PointMesh& mesh, SignRule rule, const LocatedPoints& points, std::span<std::uint8_t> signs);

}  // namespace clsdf::points

#pragma once

#include "points/point_mesh.hpp"

#include <clsdf/distance_transform.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
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
Crossings count_crossings(const PointMesh& mesh, const Vec3& point, const Vec3& in_units);

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
/// other point, crossings with the surface are counted: on the way from a point nearby, or on a ray along x.
void find_signs(const PointMesh& mesh, SignRule rule, const LocatedPoints& points, std::span<std::uint8_t> signs);

/// The sign on either side of each face, on the device: CLSDF_SIDES_ bits of kernels/point_tree.h.
///
/// A point's way to its nearest point of the surface meets no other face. So the side of the face tells its sign, if
/// the face lies apart from all that it shares no vertex with, by more than all rounding, and folds onto none: its
/// front is then the same place as the fronts beside it, and one point's crossings tell for all of them.
/// docs/method.md, 'Sides of faces', proves it.
struct FaceSides {
    device::BufferPool::Lease sides;
    std::size_t known = 0;  ///< faces whose sides are
};

/// Whether they cost less than the crossings of so many points that are asked for.
bool are_sides_worthwhile(std::size_t points, std::size_t faces);

/// Throws Error(out_of_memory).
FaceSides find_face_sides(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                          const PointMesh& mesh, SignRule rule);

/// Throws Error(invalid_argument) that names the first box that is not finite or has its corners exchanged.
void check_boxes(std::span<const Box> boxes);

/// The place of each box: see DistanceTransform::classify().
void find_places(const PointMesh& mesh, SignRule rule, std::span<const Box> boxes, double half_width,
                 std::span<BoxPlace> places);

}  // namespace clsdf::points

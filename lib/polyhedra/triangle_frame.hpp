#pragma once

#include "polyhedra/lattice_view.hpp"
#include "polyhedra/vector.hpp"
#include "polyhedron.h"

#include <array>
#include <cstdint>

namespace clsdf::polyhedra {

/// The frame of kernels/polyhedron.h in double precision, in units of the lattice. What the edges
/// around are decided by comes first, for the caches.
// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): arrays of frames are left unset until all cores fill them
struct TriangleFrame {
    Vector normal;                  ///< Z
    std::array<Vector, 3> inwards;  ///< by edge of the triangle: unit vector in the plane, perpendicular to the edge

    double altitude;
    double turn;  ///< bounds the angle by which rounding turns the frame around its edges; infinite for a box
    std::uint32_t base_edge;  ///< 0 to 2; edge k of the triangle runs from its vertex k to the next
    bool is_box;              ///< so degenerate that its lateral planes are left out: all its slopes are open

    Vector along;                ///< X, along the longest edge: the base
    Vector foot;                 ///< of the altitude, from the lattice's sample (0, 0, 0)
    std::array<double, 2> base;  ///< by half: from the foot to the end of the base

    // By half (CLSDF_HALF_RIGHT, CLSDF_HALF_LEFT), components of the slanted edge's outward normal:
    std::array<double, 2> normal_along;   ///< along X away from the foot
    std::array<double, 2> normal_across;  ///< along Y

    /// Y, from the base to the apex.
    const Vector& across() const { return inwards[base_edge]; }

    double base_length() const { return base[0] + base[1]; }

    /// Index of edge k of the triangle in the polyhedron: CLSDF_EDGE_BASE, _RIGHT or _LEFT.
    std::uint32_t polyhedron_edge(std::uint32_t k) const { return k >= base_edge ? k - base_edge : k + 3 - base_edge; }
};

/// Bounds the sum of a frame's roundings: some thirty of 2^-53 by count, 3e-15.
inline constexpr double frame_roundings = 1e-13;

/// The frame of a triangle, also of a degenerate one (twice the area <= 1e-8 times the square of the longest edge): of
/// a segment the base is the segment, of a point everything has length zero.
TriangleFrame triangle_frame(const std::array<Vec3, 3>& corners, const LatticeView& lattice);

/// The frame of an equilateral triangle that has shrunk to the point at `position`, in units.
TriangleFrame point_frame(const Vector& position, const Vector& normal);

}  // namespace clsdf::polyhedra

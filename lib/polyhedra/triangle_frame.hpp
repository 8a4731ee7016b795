#pragma once

#include "polyhedra/leaned_frusta.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/vector.hpp"

#include <array>
#include <cstdint>
#include <limits>

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

/// Differences of positions in units. They are taken before positions are brought to units: a small triangle far from
/// the lattice's origin keeps its shape to the last bit of the coordinates given.
class InUnits {
public:
    explicit InUnits(double unit) : unit_(unit), per_unit_(1 / unit) {}

    Vector difference(const Vec3& to, const Vec3& from) const {
        const Vector difference{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
        return per_unit_ < std::numeric_limits<double>::infinity() ? Vector(per_unit_ * difference)
                                                                   : Vector(difference / unit_);
    }

private:
    double unit_;
    double per_unit_;
};

/// The edges of a triangle in units, and the longest of them, the base. Edge k runs from the vertex k to the next.
/// Without branches: they could not be predicted.
struct TriangleEdges {
    std::array<Vector, 3> vectors;
    std::array<double, 3> squared;  ///< lengths
    std::uint32_t base;

    TriangleEdges(const std::array<Vec3, 3>& corners, const InUnits& in_units)
        : vectors{in_units.difference(corners[1], corners[0]), in_units.difference(corners[2], corners[1]),
                  in_units.difference(corners[0], corners[2])},
          squared{vectors[0].squaredNorm(), vectors[1].squaredNorm(), vectors[2].squaredNorm()},
          base(squared[0] >= squared[1] ? 0 : 1) {
        const std::uint32_t is_last = squared[2] > squared[base] ? 1 : 0;
        base += is_last * (2 - base);
    }

    /// Everything at the apex is measured from the nearer end of the base: on needles the other end is too far away.
    /// CLSDF_HALF_RIGHT or _LEFT.
    std::uint32_t nearer_half() const {
        return squared[next_of_three(base)] <= squared[previous_of_three(base)] ? CLSDF_HALF_RIGHT : CLSDF_HALF_LEFT;
    }
    std::uint32_t near_end() const { return (base + 1 - nearer_half()) % 3; }
    Vector apex() const {
        const std::uint32_t half = nearer_half();
        return side_of(half) * vectors[(base + 1 + half) % 3];
    }
    /// 1 for the right half, -1 for the left one.
    static double side_of(std::uint32_t half) { return 1 - 2 * static_cast<double>(half); }
};

/// The foot of the altitude, from the end of the base that is nearer to the apex.
inline Vector foot_of(const TriangleFrame& frame, const Vec3& near_end, std::uint32_t nearer_half,
                      const LatticeView& lattice, const InUnits& in_units) {
    return in_units.difference(near_end, lattice.origin) -
           TriangleEdges::side_of(nearer_half) * frame.base[nearer_half] * frame.along;
}

/// The frame of a triangle, also of a degenerate one (twice the area <= 1e-8 times the square of the longest edge): of
/// a segment the base is the segment, of a point everything has length zero.
TriangleFrame triangle_frame(const std::array<Vec3, 3>& corners, const LatticeView& lattice);

/// The frame of an equilateral triangle that has shrunk to the point at `position`, in units.
TriangleFrame point_frame(const Vector& position, const Vector& normal);

}  // namespace clsdf::polyhedra

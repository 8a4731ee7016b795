#pragma once

#include <clsdf/mesh.hpp>

#include "face_sources.h"
#include "lattice/lattice_view.hpp"
#include "polyhedron.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace clsdf::engine {

using Vector = Eigen::Vector3d;

/// Structs of kernels/frusta with one lane.
namespace one_lane {

using doubleL = double;
using longL = long;
#include "lane_frames.h"

}  // namespace one_lane

inline Vector to_vector(const Vec3& v) {
    return {v[0], v[1], v[2]};
}
inline Vector to_vector(const one_lane::Vectors& v) {
    return {v.x, v.y, v.z};
}
inline one_lane::Vectors vectors_of(const Vector& v) {
    return {v.x(), v.y(), v.z()};
}

/// A product of two vectors, summed in this order always, as in kernels/frusta/face_frames.h.
inline double dot(const Vector& a, const Vector& b) {
    return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

/// A unit vector perpendicular to the unit vector `v`.
inline Vector any_perpendicular(const Vector& v) {
    const Vector axis = std::abs(v.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
    return v.cross(axis).normalized();
}

/// The lattice as kernels take it.
inline FaceLattice face_lattice(const LatticeView& lattice) {
    FaceLattice result{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.origin[axis] = lattice.origin[axis];
        result.spacing[axis] = lattice.spacing_in_units[axis];
    }
    result.per_unit = 1 / lattice.unit;
    return result;
}

/// The frame of kernels/common/polyhedron.h in double precision, in units of the lattice, as kernels have it, and what
/// tests of edges take. Members that these read come first, for the caches.
// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): arrays of frames are left unset until all cores fill them
struct TriangleFrame {
    Vector normal;                  ///< Z
    std::array<Vector, 3> inwards;  ///< by edge of the triangle: unit vector in the plane, perpendicular to the edge

    double turn;  ///< bounds the angle by which rounding turns the frame around its edges; infinite for a box
    std::uint32_t base_edge;  ///< 0 to 2; edge k of the triangle runs from its vertex k to the next
    bool is_box;              ///< so degenerate that its lateral planes are left out: all its slopes are open

    one_lane::FaceFrames face;  ///< its foot from the lattice's sample (0, 0, 0)

    double base_length() const { return face.right + face.left; }

    /// Index of edge k of the triangle in the polyhedron: CLSDF_EDGE_BASE, _RIGHT or _LEFT.
    std::uint32_t polyhedron_edge(std::uint32_t k) const { return k >= base_edge ? k - base_edge : k + 3 - base_edge; }
};

/// The frame of a triangle, also of a degenerate one (twice the area <= 1e-8 times the square of the longest edge): of
/// a segment the base is the segment. Of a triangle no longer than 1e-100 units everything has length zero.
TriangleFrame triangle_frame(const std::array<Vec3, 3>& corners, const LatticeView& lattice);

/// The frame of an equilateral triangle that has shrunk to the point at `position`, in units.
TriangleFrame point_frame(const Vector& position, const Vector& normal);

/// Faces of a mesh, in an order of their own, as seen from a lattice.
struct MeshFaces {
    std::span<const Vec3> positions;  ///< of the vertices
    std::span<const Triangle> triangles;
    const LatticeView& lattice;

    const Vec3& position(std::uint32_t vertex) const { return positions[vertex]; }
    std::array<Vec3, 3> corners(std::size_t face) const {
        const auto& [a, b, c] = triangles[face];
        return {position(a), position(b), position(c)};
    }
    TriangleFrame frame(std::size_t face) const { return triangle_frame(corners(face), lattice); }
};

}  // namespace clsdf::engine

#include "polyhedra/dihedral.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <cmath>

namespace clsdf::polyhedra {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Mesh& mesh, std::uint32_t vertex) {
    const Vec3& v = mesh.vertices()[vertex];
    return {v[0], v[1], v[2]};
}

/// Bounds the angle by which rounding turns a frame around its edges: some ten roundings of its longest edge, seen from
/// its altitude.
double frame_error(const TriangleFrame& frame) {
    constexpr double roundings = 1e-13;  // counted: some thirty of 2^-53, 3e-15
    return roundings * frame.base_length() / frame.altitude();
}

}  // namespace

int side_of_plane(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const TriangleFrame> frames,
                  const Corner& first, const Corner& second) {
    const TriangleFrame& first_frame = frames[first.face];
    const TriangleFrame& second_frame = frames[second.face];
    if (!first_frame.is_box && !second_frame.is_box) {
        const double sine = second_frame.inward(second.vertex).dot(first_frame.normal);
        if (std::abs(sine) > frame_error(first_frame) + frame_error(second_frame)) return sine > 0 ? 1 : -1;
    }
    const Triangle& triangle = triangles[first.face];
    const std::uint32_t opposite = triangles[second.face][previous_of_three(second.vertex)];
    return static_cast<int>(CGAL::orientation(point(mesh, triangle[0]), point(mesh, triangle[1]),
                                              point(mesh, triangle[2]), point(mesh, opposite)));
}

}  // namespace clsdf::polyhedra

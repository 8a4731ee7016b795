#include "polyhedra/dihedral.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace clsdf::polyhedra {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Mesh& mesh, std::uint32_t vertex) {
    const Vec3& v = mesh.vertices()[vertex];
    return {v[0], v[1], v[2]};
}

}  // namespace

int side_of_plane(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const TriangleFrame> frames,
                  const Corner& first, const Corner& second) {
    const double sine = frames[second.face].inwards[second.vertex].dot(frames[first.face].normal);
    if (const int side = certain_side(frames[first.face], frames[second.face], sine)) return side;
    const Triangle& triangle = triangles[first.face];
    const std::uint32_t opposite = triangles[second.face][previous_of_three(second.vertex)];
    return static_cast<int>(CGAL::orientation(point(mesh, triangle[0]), point(mesh, triangle[1]),
                                              point(mesh, triangle[2]), point(mesh, opposite)));
}

}  // namespace clsdf::polyhedra

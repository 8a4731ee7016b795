#pragma once

#include "polyhedra/vector.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// The bounding polyhedra as Peikert & Sigg published them. They are not exact (docs/method.md, 'Why the published
/// polyhedra are not exact'): they are here to be compared with.
namespace clsdf::peikert_sigg {

/// The slab of the half width about a triangle, cut by the bisector planes of the dihedral angles at its edges.
struct Polyhedron {
    std::uint32_t triangle = 0;  ///< index in the mesh
    polyhedra::Vector normal;
    double half_width = 0;
    // By edge; edge k runs from the triangle's vertex k to the next:
    std::array<polyhedra::Vector, 3> corners;   ///< where the edge begins
    std::array<polyhedra::Vector, 3> bisector;  ///< unit normal of its lateral plane, pointing outward
    std::array<double, 3> shift{};              ///< how far gap closing moved the plane outward

    bool contains(const polyhedra::Vector& point) const;
};

/// The remedy for a gap: the lateral planes at a vertex moved outward until every polyhedron there has `vertex + point`
/// and `vertex - point` within its two.
struct GapClosing {
    std::uint32_t vertex = 0;
    polyhedra::Vector point;
};

struct Polyhedra {
    std::vector<Polyhedron> polyhedra;  ///< of each triangle with three different vertices, in the mesh's order
    std::vector<GapClosing> closings;   ///< of the vertices at which the published test fails
};

/// Where an edge does not have exactly one other face, or one that is folded onto the triangle, the lateral plane is
/// perpendicular to the triangle. `half_width` > 0 in the mesh's units.
Polyhedra peikert_sigg_polyhedra(const Mesh& mesh, double half_width, bool close_gaps = true);

}  // namespace clsdf::peikert_sigg

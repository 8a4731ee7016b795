#pragma once

#include "papers/pieces.hpp"
#include "polyhedra/frames.hpp"
#include "polyhedra/records.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// The bounding polyhedra as Peikert & Sigg published them. They are not exact (docs/method.md, 'Why the published
/// polyhedra are not exact'): they are here to be compared with.
namespace clsdf::papers {

/// The slab of the half width about a triangle, cut by the bisector planes of the dihedral angles at its edges.
struct BisectorPolyhedron {
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

struct BisectorPolyhedra {
    std::vector<BisectorPolyhedron> polyhedra;  ///< of each triangle with three different vertices, in the mesh's order
    std::vector<GapClosing> closings;           ///< of the vertices at which the published test fails
};

/// Where an edge does not have exactly one other face, or one that is folded onto the triangle, the lateral plane is
/// perpendicular to the triangle. `half_width` > 0 in the mesh's units.
BisectorPolyhedra peikert_sigg_polyhedra(const Mesh& mesh, double half_width, bool close_gaps = true);

struct PeikertSiggPieces {
    UninitializedVector<Polyhedron> polyhedra;  ///< for the distances alone: without slopes
    ConvexPieces pieces;                        ///< one a polyhedron
    std::size_t closed_gaps = 0;                ///< vertices at which the published test fails
};

/// The polyhedra that Peikert & Sigg published, for a band of `half_width` units. They are not
/// widened: CLSDF_PIECE_SLACK repairs none of their errors.
PeikertSiggPieces peikert_sigg_pieces(const Mesh& mesh, const polyhedra::LatticeView& lattice, double half_width,
                                      bool close_gaps, const Layout& grid);

}  // namespace clsdf::papers

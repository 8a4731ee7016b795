#pragma once

#include "papers/convex_polyhedron.hpp"
#include "papers/pieces.hpp"
#include "polyhedra/records.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>

namespace clsdf::papers {

struct MauchPieces {
    UninitializedVector<Polyhedron> polyhedra;  ///< of the triangles, for the distances alone: no slopes
    ConvexPieces pieces;
    std::size_t towers = 0;
    std::size_t wedges = 0;
    std::size_t cones = 0;
    std::size_t boxes = 0;  ///< of degenerate triangles

    std::size_t count() const { return towers + wedges + cones + boxes; }
};

/// Mauch's polyhedra (S. Mauch, Efficient Algorithms for Solving Static Hamilton-Jacobi Equations, 2003), for a band of
/// `half_width` units: a tower on both sides of each face, a wedge at each edge, a cone at each vertex, each with the
/// distance to its own site. They are the sites' normal cones (docs/method.md, 'What an exact polyhedron must
/// contain'), and therefore exact for every set of triangles, not only for closed surfaces: at an edge the one sector,
/// at a vertex the one cone whose directions lead away from all faces there. An edge whose faces are in one plane has
/// none, nor has a vertex whose neighbours surround it.
///
/// A face too degenerate for its walls to be known within CLSDF_PIECE_SLACK gets a box with the distance to the nearest
/// of its seven sites instead, which does for its edges and vertices too.
MauchPieces mauch_pieces(const Mesh& mesh, const polyhedra::LatticeView& lattice, double half_width,
                         const Layout& grid);

}  // namespace clsdf::papers

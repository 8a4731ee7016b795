#pragma once

#include "polyhedra/records.hpp"
#include "slices/convex_pieces.hpp"

namespace clsdf::slices {

struct PeikertSiggPieces {
    UninitializedVector<Polyhedron> polyhedra;  ///< for the distances alone: without slopes
    ConvexPieces pieces;                        ///< one a polyhedron
    std::size_t closed_gaps = 0;                ///< vertices at which the published test fails
};

/// The polyhedra that Peikert & Sigg published (lib/peikert_sigg), for a band of `half_width` units. They are not
/// widened: CLSDF_PIECE_SLACK repairs none of their errors.
PeikertSiggPieces peikert_sigg_pieces(const Mesh& mesh, const polyhedra::LatticeView& lattice, double half_width,
                                      bool close_gaps, const Layout& grid);

}  // namespace clsdf::slices

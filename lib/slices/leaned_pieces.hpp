#pragma once

#include "slices/convex_pieces.hpp"

#include <span>

namespace clsdf::slices {

/// The pieces of leaned frusta: of each the part above its face and that below, both convex, widened by `slack` units
/// and cut at `half_width`. They are the sides that the record's test takes together (kernels/polyhedron.h), but for
/// what that mixes of both within the slack about the face; each by itself holds what docs/method.md, 'Why nothing is
/// lost', asks of it.
ConvexPieces leaned_pieces(std::span<const Polyhedron> polyhedra, double half_width, double slack, const Layout& grid);

}  // namespace clsdf::slices

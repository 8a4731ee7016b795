#pragma once

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <span>

namespace clsdf::polyhedra {

/// Whether it is certain that no direction is rejected by all faces of a fan, by the margin, each at the edge given
/// (docs/method.md, 'Gaps at saddle vertices'). The faces have one orientation. Answers no where it cannot tell
/// cheaply; that is rare where few faces meet.
bool cannot_all_reject(std::span<const TriangleFrame> frames, std::span<const FaceEdges> faces,
                       std::span<const Corner> edges, double margin);

}  // namespace clsdf::polyhedra

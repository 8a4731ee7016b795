#pragma once

#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/pair_edges.hpp"
#include "polyhedra/slopes.hpp"

#include <vector>

namespace clsdf::polyhedra {

/// The slopes at edges where three faces or more meet, for EdgeSlopes; sets their places (FaceEdges::across) and
/// edge_at_box.
std::vector<EdgeSlope> non_manifold_slopes(const MeshFaces& faces, const OneRings& rings, PairedEdges& edges,
                                           float open);

}  // namespace clsdf::polyhedra

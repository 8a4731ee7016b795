#pragma once

#include "polyhedra/face_edges.hpp"
#include "polyhedra/gap_screen.hpp"
#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/record_planes.hpp"

#include <cstdint>
#include <span>

namespace clsdf::polyhedra {

/// A direction that is rejected by less than this lies within a quarter of the slack of the polyhedron (docs/method.md,
/// 'Gaps at saddle vertices').
double rejection_margin(double half_width, double slack);

/// Sets the marks of `vertices`. A vertex without vertex_gap has its whole normal cone in its faces' polyhedra, widened
/// by a quarter of the slack.
void find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
               const RecordPlanes& planes, double margin, std::span<const std::uint32_t> vertices,
               std::span<std::uint8_t> marks);

}  // namespace clsdf::polyhedra

#pragma once

#include "polyhedra/face_edges.hpp"
#include "polyhedra/frame_planes.hpp"
#include "polyhedra/gap_screen.hpp"
#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/one_rings.hpp"

#include <cstdint>
#include <span>

namespace clsdf::polyhedra {

/// A direction that is rejected by less than this lies within a quarter of the slack of the polyhedron (docs/method.md,
/// 'Gaps at saddle vertices').
///
/// A quarter of the slack 1e-3 + 2e-5 d is d times this or more, for every distance d in units.
inline constexpr double rejection_margin = 5e-6;

/// Sets the marks of `vertices`. A vertex without vertex_gap has its whole normal cone in its faces' polyhedra, widened
/// by a quarter of the slack.
void find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
               const FramePlanes& planes, double margin, std::span<const std::uint32_t> vertices,
               std::span<std::uint8_t> marks);

}  // namespace clsdf::polyhedra

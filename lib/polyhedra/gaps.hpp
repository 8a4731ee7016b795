#pragma once

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

enum VertexMark : std::uint8_t {
    vertex_saddle = 1,  ///< convex and concave edges meet there
    vertex_gap = 2,     ///< directions may be left out by the polyhedra of all its faces: it needs a point site
};

/// The marks of every vertex (docs/method.md, 'Gaps at saddle vertices'). A vertex without vertex_gap has its whole
/// normal cone in its faces' polyhedra, widened by a quarter of the slack.
std::vector<std::uint8_t> find_gaps(const Mesh& mesh, std::span<const Triangle> triangles,
                                    std::span<const TriangleFrame> frames, std::span<const FaceEdges> faces,
                                    const OneRings& rings, const LatticeView& lattice, double half_width, double slack);

}  // namespace clsdf::polyhedra

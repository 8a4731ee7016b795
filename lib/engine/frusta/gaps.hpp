#pragma once

#include "frusta/frames.hpp"
#include "frusta/slopes.hpp"
#include "topology/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::engine {

enum VertexMark : std::uint8_t {
    vertex_saddle = 1,  ///< convex and concave edges meet there
    vertex_gap = 2,     ///< directions may be left out by the polyhedra of all its faces: it needs a point site
};

/// The factor of positions in the gap test: lengths are then of the order of one.
double gap_scale(const LatticeView& lattice);

/// VertexMark of each of `vertices`. A vertex without vertex_gap has its whole normal cone in its faces' polyhedra,
/// widened by a quarter of the slack. `measured`: at least all faces around them; their slopes are leaned.
std::vector<std::uint8_t> find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
                                    const MeasuredFaces& measured, std::span<const std::uint32_t> vertices);

}  // namespace clsdf::engine

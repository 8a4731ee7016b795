#pragma once

#include "core/uninitialized_vector.hpp"
#include "polyhedra/face_edges.hpp"
#include "polyhedra/one_rings.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The faces that meet at each edge.
struct PairedEdges {
    /// For each face, the data that follow from the vertices' indices: edge_open, edge_non_manifold, edge_unoriented,
    /// edge_at_box of an edge from a vertex to itself, and the faces across. The frames' bases are not set yet.
    UninitializedVector<FaceEdges> faces;
    std::vector<std::uint32_t>
        non_manifold_ends;                 ///< lower ends of edges where three faces or more meet, in ascending order
    std::size_t non_manifold_corners = 0;  ///< of faces, at such edges
};

PairedEdges pair_edges(std::span<const Triangle> triangles, const OneRings& rings);

}  // namespace clsdf::polyhedra

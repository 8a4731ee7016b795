#pragma once

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <span>

namespace clsdf::polyhedra {

/// The polyhedron of a vertex by itself: it holds the vertex' whole normal cone.
struct PointSite {
    TriangleFrame frame;
    FaceEdges edges{};
    std::uint32_t face = 0;  ///< of the list: of the vertex' faces the one that comes first in the caller's order
};

/// `order`: the caller's index of each face of the list.
PointSite point_site(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> order,
                     const OneRings& rings, std::size_t vertex, const LatticeView& lattice, float open);

}  // namespace clsdf::polyhedra

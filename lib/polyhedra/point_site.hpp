#pragma once

#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/slopes.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <span>

namespace clsdf::polyhedra {

/// The polyhedron of a vertex by itself: it holds the vertex' whole normal cone.
struct PointSite {
    TriangleFrame frame;
    FaceSlopes slopes{};
    std::uint32_t face = 0;  ///< of the list: of the vertex' faces the one that comes first in the caller's order
};

/// `order`, `vertices`: the caller's indices of the faces and of the vertices.
PointSite point_site(const MeshFaces& faces, std::span<const std::uint32_t> order,
                     std::span<const std::uint32_t> vertices, const OneRings& rings, std::uint32_t vertex, float open);

}  // namespace clsdf::polyhedra

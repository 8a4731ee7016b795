#pragma once

#include "polyhedra/frusta.hpp"
#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/one_rings.hpp"

#include <span>

namespace clsdf::polyhedra {

/// The frustum of a vertex by itself: it holds the vertex' whole normal cone. `order`, `vertices`: the caller's indices
/// of the faces and of the vertices.
SiteFrustum point_site(const MeshFaces& faces, std::span<const std::uint32_t> order,
                       std::span<const std::uint32_t> vertices, const OneRings& rings, std::uint32_t vertex);

}  // namespace clsdf::polyhedra

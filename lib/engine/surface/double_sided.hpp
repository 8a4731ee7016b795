#pragma once

#include <clsdf/mesh.hpp>

#include "surface/open_edges.hpp"
#include "surface/parts.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// Some faces of a mesh as a surface of their own.
struct SubSurface {
    std::vector<std::uint32_t> faces;  ///< of the mesh, ascending
    Mesh surface;                      ///< these faces
    OrientedParts parts;               ///< of the surface

    /// triangles: of these faces, over the mesh's vertices.
    SubSurface(const Mesh& mesh, std::span<const Triangle> triangles, std::vector<std::uint32_t> own_faces);
};

/// A face and how it counts.
struct CountedFace {
    std::uint32_t face;
    bool is_turned;
};

/// Bodies whose faces are there on both sides, so that nothing is inside (docs/sign.md, 'Bodies that are there on both
/// sides'): the faces that count, ascending. candidates: the lowest of faces that cancel each other. counting, loops:
/// the surface without them. may_open: bodies with a hole count. volume: six times that of the bodies.
std::vector<CountedFace> double_sided_bodies(const Mesh& mesh, const SubSurface& candidates,
                                             std::span<const Triangle> counting, const OpenLoops& loops, bool may_open,
                                             double& volume);

/// Faces that are there more often than once and bound a cavity that is filled thereby: the winding numbers of their
/// two sides differ in sign. candidates: the lowest of equal faces of a balanced surface. Returns the lowest ones,
/// ascending.
std::vector<std::uint32_t> doubled_cavities(const Mesh& mesh, std::span<const Triangle> triangles,
                                            std::vector<std::uint32_t> candidates);

}  // namespace clsdf

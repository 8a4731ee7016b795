#pragma once

#include <clsdf/mesh.hpp>

#include "surface/open_edges.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// A face and how it counts.
struct CountedFace {
    std::uint32_t face;
    bool is_turned;
};

/// Bodies whose faces are there on both sides, so that nothing is inside (docs/sign.md, 'Bodies that are there on both
/// sides'): the faces that count, ascending. candidates: the lowest of faces that cancel each other, in `given`.
/// counting, loops: the surface without them. is_inside_out: it encloses a negative volume. may_open: bodies with a
/// hole count.
std::vector<CountedFace> double_sided_bodies(const Mesh& mesh, std::span<const Triangle> given,
                                             std::span<const std::uint32_t> candidates,
                                             std::span<const Triangle> counting, const OpenLoops& loops, bool may_open,
                                             double& volume);

/// Faces that are there more often than once and bound a cavity that is filled thereby: the winding numbers of their
/// two sides differ in sign. candidates: the lowest of equal faces of a balanced surface. Returns the lowest ones,
/// ascending.
std::vector<std::uint32_t> doubled_cavities(const Mesh& mesh, std::span<const Triangle> triangles,
                                            std::span<const std::uint32_t> candidates);

}  // namespace clsdf

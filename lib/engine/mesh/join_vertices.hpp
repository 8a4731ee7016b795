#pragma once

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// A cluster of joined vertices that is longer, as a multiple of the tolerance, is left apart.
inline constexpr double longest_cluster = 4;

/// A vertex that is joined, and the one of its cluster whose position is least in (x, y, z).
struct JoinedVertex {
    std::uint32_t vertex;
    std::uint32_t least;
};

/// Joins those of the candidates (numbers of positions, all different) that differ by at most `tolerance` on every
/// axis, and what is connected that way, unless the cluster is longer than longest_cluster tolerances on an axis.
/// Returns the vertices that are not the least of their cluster, ascending.
std::vector<JoinedVertex> join_vertices(std::span<const Vec3> positions, std::vector<std::uint32_t> candidates,
                                        double tolerance);

}  // namespace clsdf

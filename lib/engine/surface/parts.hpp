#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "mesh/one_rings.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

inline bool has_repeated_vertex(const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// Parts of a surface for its orientation: sets of faces that are joined over edges of exactly two faces. Faces with
/// repeated vertices are in no part.
struct OrientedParts {
    std::vector<std::uint32_t> part;   ///< by face: the lowest face of its part
    std::vector<bool> is_turned;       ///< whether it is oriented differently from that one
    std::vector<bool> is_orientable;   ///< by the lowest face of a part
    std::vector<EdgeEntry> entries{};  ///< the faces of edges of more or fewer than two faces, edge after edge
    std::vector<std::size_t> edges{};  ///< where each of these edges begins in `entries`, and the end of the last

    OrientedParts(std::span<const Triangle> triangles, std::size_t vertex_count);
};

/// The faces that look otherwise than most of the area of their part, or than its lowest face if there is no most. If a
/// part cannot be oriented: nothing of this part, or nothing at all if all of them are wanted.
std::vector<std::uint32_t> faces_to_turn(const Mesh& mesh, std::span<const Triangle> triangles, bool are_all_wanted);

/// Inner walls: parts that a surface with edges of three faces would be closed without, the smallest first. Their
/// faces, ascending; nothing if the surface would not be closed.
std::vector<std::uint32_t> inner_walls(const Mesh& mesh, std::span<const Triangle> triangles);

/// Whether all faces are joined over vertices. Fast if neighbours follow each other and are numbered alike.
bool is_one_part(std::span<const Triangle> triangles, std::size_t vertex_count);

/// Counts the parts of a balanced surface that share no vertex, and finds those that look inwards beside others and
/// those that are filled.
void describe_parts(const Mesh& mesh, std::span<const Triangle> triangles, Topology& report);

}  // namespace clsdf

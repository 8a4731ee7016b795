#pragma once

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// How a face counts for the sign of a body whose faces meet in edges of three or more (docs/sign.md, 'Walls within a
/// body').
enum class FaceRole : std::uint8_t {
    as_before,  ///< of a surface that is not of this kind, or that has no inside
    forward,    ///< of the skin; looks outwards, or inwards if most of the skin does so
    backward,   ///< of the skin, and looks the other way
    wall,       ///< has the same on both sides
    sheet       ///< the same, in what can be reached from afar
};

/// The roles of faces, by reachability: outside is what is reached from afar without crossing a face. Around an edge
/// the faces stand in an order, and each side is joined to the next one's; at an edge of one face its two sides are. A
/// surface whose faces cross elsewhere than at common edges, or that encloses nothing, keeps its faces `as_before`.
///
/// triangles: vertices that are the same have the same number, no two faces have the same three, and faces with a
/// vertex twice do not count. closing: of them the last ones that close edges (corners_in_edges_of_walls()). Empty if
/// no face has another role.
std::vector<FaceRole> roles_by_reach(const Mesh& mesh, std::span<const Triangle> triangles, std::size_t closing = 0);

}  // namespace clsdf

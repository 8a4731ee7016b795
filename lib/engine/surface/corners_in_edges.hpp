#pragma once

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// A triangle that closes an open edge on which corners of other faces lie: two ends of it, or a corner.
struct ClosingTriangle {
    Triangle corners;    ///< it has no area but for rounding
    std::uint32_t face;  ///< that has the edge,
    std::uint32_t from;  ///< which begins there, and ends at the first corner
};

/// The triangles between open edges and the corners of other faces that lie in them within 2^-43 of the mesh's longest
/// side, as where the side of a box is two triangles and its lid is divided finer. An edge is closed if each part of
/// it, from corner to corner, is an open edge of another face, in the opposite direction; edges that are divided on
/// both sides are closed together, if fewer are open then. vertices that are the same have the same number.
std::vector<ClosingTriangle> corners_in_edges(const Mesh& mesh, std::span<const Triangle> triangles);

/// The same whichever way faces look, and for edges of several faces, as those of an inner wall: where each part of an
/// edge is an edge of one other face.
std::vector<Triangle> corners_in_edges_of_walls(const Mesh& mesh, std::span<const Triangle> triangles);

}  // namespace clsdf

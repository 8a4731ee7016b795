#pragma once

#include <array>
#include <cstdint>

namespace clsdf::polyhedra {

/// What an edge is to the vertices at its ends; several may hold.
enum EdgeMark : std::uint8_t {
    edge_convex = 1,        ///< of two faces that run along it in opposite directions, by the exact orientation of
    edge_concave = 2,       ///< the coordinates as given; neither: flat
    edge_open = 4,          ///< one face, or two folded onto each other: no plane cuts there
    edge_non_manifold = 8,  ///< three faces or more
    edge_unoriented =
        16,            ///< two faces that run along it the same way: what is convex for one is concave for the other
    edge_at_box = 32,  ///< one of its faces is so degenerate that its polyhedron is a box
    edge_folded = 64,  ///< open because its two faces are folded onto each other
};

/// Data of the edges of a face; edge k runs from the face's vertex k to the next.
struct FaceEdges {
    /// The other face's edge, packed, if there is exactly one other face. If there are more, the index of the edge's
    /// slopes among those of all such edges.
    std::array<std::uint32_t, 3> across;
    std::array<std::uint8_t, 3> marks;
    std::uint8_t base;  ///< the edge that is its frame's base
};

}  // namespace clsdf::polyhedra

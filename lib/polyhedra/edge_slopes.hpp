#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"
#include "polyhedra/uninitialized_vector.hpp"

#include <array>
#include <cstdint>
#include <span>

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

/// Of each edge of a face; edge k runs from the face's vertex k to the next.
struct FaceEdges {
    std::array<float, 3> above;  ///< slope of its lateral plane above the face (docs/method.md, 'Leaned frusta') and
    std::array<float, 3> below;  ///< below it, rounded up to float
    std::array<std::uint32_t, 3> across;  ///< the other face's edge, packed, where there is exactly one other face
    std::array<std::uint8_t, 3> marks;
};

/// The slope that no point of the band gets past (docs/method.md, 'Leaned frusta'): open * slack >= half_width.
float open_slope(double half_width, double slack);

/// `x` >= 0 as a float that is not below it, also after the roundings that led to it.
inline float widened(double x) {
    return static_cast<float>(x * (1 + 1e-6));
}

/// The half wedges of every face: each face at an edge takes the angle up to the bisector with the next face on that
/// side, and the whole wedge where there is none. Not yet leaned.
UninitializedVector<FaceEdges> edge_slopes(const Mesh& mesh, std::span<const Triangle> triangles,
                                           std::span<const TriangleFrame> frames, const OneRings& rings, float open,
                                           ScratchMemory* scratch = nullptr);

/// Where the corner opposite the base is obtuse, its two planes lean outward so that each contains what the other
/// contains: the obtuse corner's vertices are cut off otherwise. No other corner of a triangle is obtuse.
void lean(const TriangleFrame& frame, FaceEdges& edges);

}  // namespace clsdf::polyhedra

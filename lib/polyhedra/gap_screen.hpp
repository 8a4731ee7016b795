#pragma once

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/face_edges.hpp"
#include "polyhedra/fan_screen.hpp"
#include "polyhedra/one_rings.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

enum VertexMark : std::uint8_t {
    vertex_saddle = 1,  ///< convex and concave edges meet there
    vertex_gap = 2,     ///< directions may be left out by the polyhedra of all its faces: it needs a point site
};

/// Marks of the edges at a vertex.
struct EdgesAround {
    std::uint8_t marks = 0;

    EdgesAround() = default;
    EdgesAround(std::span<const FaceEdges> edges, const OneRings& rings, std::size_t vertex) {
        for (std::size_t i = 0; i < rings.size(vertex); ++i) add(edges, rings.corner(vertex, i));
    }

    /// The two of a face.
    void add(std::span<const FaceEdges> edges, const Corner& corner) {
        const FaceEdges& face = edges[corner.face];
        marks |= face.marks[corner.vertex];
        marks |= face.marks[previous_of_three(corner.vertex)];
    }

    bool has(std::uint8_t mark) const { return (marks & mark) != 0; }
    bool are_mixed() const { return has(edge_convex) && has(edge_concave); }
    std::uint8_t vertex_mark() const { return are_mixed() ? vertex_saddle : 0; }
    /// Each has two faces, of one orientation.
    bool are_plain() const { return !has(edge_at_box | edge_non_manifold | edge_open | edge_unoriented); }
};

/// Marks vertices, and finds most of those that surely need no point site, while the frames of their faces are at hand.
class GapScreen {
public:
    /// `first_vertices`: OrderedFaces::first_vertices
    GapScreen(std::span<const std::uint32_t> first_vertices, std::span<const FaceEdges> edges, const OneRings& rings,
              double margin, std::span<std::uint8_t> marks)
        : first_vertices_(first_vertices), edges_(edges), rings_(rings), marks_(marks), fans_(edges, rings, margin) {}

    /// The vertices that the stretch is the first to name. Its slopes are leaned.
    void look_at(const EdgeSlopes& stretch);

    /// The vertices that are left to find_gaps(): also those with faces outside their stretch, which have no marks yet.
    const std::vector<std::uint32_t>& finish() { return fans_.finish(); }

private:
    std::span<const std::uint32_t> first_vertices_;
    std::span<const FaceEdges> edges_;
    const OneRings& rings_;
    std::span<std::uint8_t> marks_;
    FanScreen fans_;
};

}  // namespace clsdf::polyhedra

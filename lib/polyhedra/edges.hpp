#pragma once

#include "core/uninitialized_vector.hpp"
#include "polyhedra/one_rings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

/// A face's edge, filed under one of its vertices; in order, the faces of an edge follow each other.
class EdgeEntry {
public:
    EdgeEntry(std::uint32_t other_vertex, Corner edge)
        : key_(static_cast<std::uint64_t>(other_vertex) << 32 | edge.packed()) {}

    std::uint32_t other_vertex() const { return static_cast<std::uint32_t>(key_ >> 32); }
    Corner edge() const { return Corner::unpack(static_cast<std::uint32_t>(key_)); }

    bool operator<(const EdgeEntry& other) const { return key_ < other.key_; }

private:
    std::uint64_t key_;
};

/// Collects the faces' edges between `vertex` and those others that `is_wanted`.
template <typename Predicate>
void edges_to(std::span<const Triangle> triangles, const OneRings& rings, std::uint32_t vertex,
              const Predicate& is_wanted, std::vector<EdgeEntry>& entries) {
    entries.clear();
    for (std::size_t i = 0; i < rings.size(vertex); ++i) {
        const Corner corner = rings.corner(vertex, i);
        const Triangle& triangle = triangles[corner.face];
        const std::uint32_t previous = previous_of_three(corner.vertex);
        const std::uint32_t to = triangle[next_of_three(corner.vertex)];
        const std::uint32_t from = triangle[previous];
        if (is_wanted(to)) entries.emplace_back(to, corner);
        if (is_wanted(from)) entries.emplace_back(from, Corner{corner.face, previous});
    }
    std::sort(entries.begin(), entries.end());
}

/// Collects the faces' edges at `vertex`, but for those that lead back to it.
inline void edges_at(std::span<const Triangle> triangles, const OneRings& rings, std::uint32_t vertex,
                     std::vector<EdgeEntry>& entries) {
    edges_to(
        triangles, rings, vertex, [vertex](std::uint32_t other) { return other != vertex; }, entries);
}

/// Collects the faces' edges of which `vertex` is the lower end.
inline void edges_above(std::span<const Triangle> triangles, const OneRings& rings, std::uint32_t vertex,
                        std::vector<EdgeEntry>& entries) {
    edges_to(
        triangles, rings, vertex, [vertex](std::uint32_t other) { return other > vertex; }, entries);
}

/// Calls f(faces) for each edge of a collection, with the entries of all its faces.
template <typename Function>
void for_each_edge(const std::vector<EdgeEntry>& entries, const Function& f) {
    for (auto first = entries.begin(); first != entries.end();) {
        const auto last = std::find_if(first, entries.end(), [first](const EdgeEntry& entry) {
            return entry.other_vertex() != first->other_vertex();
        });
        f(std::span<const EdgeEntry>(first, last));
        first = last;
    }
}

/// Whether three faces or more meet at an edge, or one that has a vertex twice takes it twice.
inline bool is_non_manifold(std::span<const EdgeEntry> faces) {
    return faces.size() > 2 || (faces.size() == 2 && faces[0].edge().face == faces[1].edge().face);
}

/// The faces that meet at each edge.
struct PairedEdges {
    /// For each face, the data that follow from the vertices' indices: edge_open, edge_non_manifold, edge_unoriented,
    /// edge_at_box of an edge from a vertex to itself, and the faces across. The frames' bases are not set yet.
    UninitializedVector<FaceEdges> faces;
    std::vector<std::uint32_t>
        non_manifold_ends;                 ///< lower ends of edges where three faces or more meet, in ascending order
    std::size_t non_manifold_corners = 0;  ///< of faces, at such edges
};

PairedEdges pair_edges(std::span<const Triangle> triangles, const OneRings& rings);

}  // namespace clsdf::polyhedra

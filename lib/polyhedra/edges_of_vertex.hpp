#pragma once

#include "polyhedra/one_rings.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

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

}  // namespace clsdf::polyhedra

#pragma once

#include "polyhedra/one_rings.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// A face's edge, filed under the lower of its vertices; in order, the faces of an edge follow each other.
class EdgeEntry {
public:
    EdgeEntry(std::uint32_t higher_vertex, Corner edge)
        : key_(static_cast<std::uint64_t>(higher_vertex) << 32 | edge.packed()) {}

    std::uint32_t higher_vertex() const { return static_cast<std::uint32_t>(key_ >> 32); }
    Corner edge() const { return Corner::unpack(static_cast<std::uint32_t>(key_)); }

    bool operator<(const EdgeEntry& other) const { return key_ < other.key_; }

private:
    std::uint64_t key_;
};

/// Collects the faces' edges of which `vertex` is the lower end.
inline void edges_above(std::span<const Triangle> triangles, const OneRings& rings, std::uint32_t vertex,
                        std::vector<EdgeEntry>& entries) {
    entries.clear();
    for (std::size_t i = 0; i < rings.size(vertex); ++i) {
        const Corner corner = rings.corner(vertex, i);
        const Triangle& triangle = triangles[corner.face];
        const std::uint32_t previous = previous_of_three(corner.vertex);
        const std::uint32_t to = triangle[next_of_three(corner.vertex)];
        const std::uint32_t from = triangle[previous];
        if (to > vertex) entries.emplace_back(to, corner);
        if (from > vertex) entries.emplace_back(from, Corner{corner.face, previous});
    }
    std::sort(entries.begin(), entries.end());
}

/// Calls f(faces) for each edge of a collection, with the entries of all its faces.
template <typename Function>
void for_each_edge(const std::vector<EdgeEntry>& entries, const Function& f) {
    for (auto first = entries.begin(); first != entries.end();) {
        const auto last = std::find_if(first, entries.end(), [first](const EdgeEntry& entry) {
            return entry.higher_vertex() != first->higher_vertex();
        });
        f(std::span<const EdgeEntry>(first, last));
        first = last;
    }
}

}  // namespace clsdf::polyhedra

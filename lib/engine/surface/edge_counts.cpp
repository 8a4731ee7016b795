#include "surface/edge_counts.hpp"

#include "core/parallel.hpp"
#include "surface/parts.hpp"

#include <algorithm>

namespace clsdf {

void EdgeCounts::add(std::span<const Triangle> triangles, std::uint32_t lower, std::span<const EdgeEntry> faces) {
    const auto leaving = static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), [&](const EdgeEntry& face) {
        return triangles[face.edge().face][face.edge().vertex] == lower;
    }));
    if (2 * leaving != faces.size())
        unbalanced.push_back({lower, faces[0].other_vertex(), faces.size() % 2 != 0,
                              2 * static_cast<std::int64_t>(leaving) - static_cast<std::int64_t>(faces.size())});
    if (faces.size() == 1) ++boundary;
    if (faces.size() > 2) ++non_manifold;
}

void EdgeCounts::append(const EdgeCounts& later) {
    boundary += later.boundary;
    non_manifold += later.non_manifold;
    unbalanced.insert(unbalanced.end(), later.unbalanced.begin(), later.unbalanced.end());
}

std::size_t EdgeCounts::open() const {
    return static_cast<std::size_t>(
        std::count_if(unbalanced.begin(), unbalanced.end(), [](const UnbalancedEdge& edge) { return edge.is_open; }));
}

EdgeCounts count_edges(std::span<const Triangle> triangles, std::size_t vertex_count) {
    const OneRings rings(triangles, vertex_count);
    constexpr std::size_t chunk = 4096;
    std::vector<EdgeCounts> counts(chunk_count(vertex_count, chunk));
    for_each_chunk(vertex_count, chunk, [&](std::size_t s, std::size_t begin, std::size_t end) {
        std::vector<EdgeEntry> entries;
        for (std::size_t v = begin; v != end; ++v) {
            if (pair_ring(triangles, rings, v, [](const Corner&, const Corner&) {})) continue;
            const auto vertex = static_cast<std::uint32_t>(v);
            edges_above(triangles, rings, vertex, entries);
            std::erase_if(entries,
                          [&](const EdgeEntry& entry) { return has_repeated_vertex(triangles[entry.edge().face]); });
            for_each_edge(entries, [&](std::span<const EdgeEntry> faces) { counts[s].add(triangles, vertex, faces); });
        }
    });
    EdgeCounts all;
    for (const EdgeCounts& of_chunk : counts) all.append(of_chunk);
    return all;
}

}  // namespace clsdf

#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/one_rings.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

namespace clsdf {

/// An edge that is not used equally often in both directions.
struct UnbalancedEdge {
    std::uint32_t lower;
    std::uint32_t higher;
    bool is_open = false;
    std::int64_t net = 0;  ///< faces that use it from `lower` to `higher`, minus the others
    bool is_noted = false;

    friend bool operator<(const UnbalancedEdge& a, const UnbalancedEdge& b) {
        return std::tie(a.lower, a.higher) < std::tie(b.lower, b.higher);
    }
};

struct EdgeCounts {
    std::size_t boundary = 0;
    std::size_t non_manifold = 0;
    std::vector<UnbalancedEdge> unbalanced{};  ///< sorted

    /// An edge with all its faces.
    void add(std::span<const Triangle> triangles, std::uint32_t lower, std::span<const EdgeEntry> faces);
    /// Adds the counts of the vertices after these.
    void append(const EdgeCounts& later);

    std::size_t open() const;
};

/// Counts the edges of triangles; those with a repeated vertex have none.
EdgeCounts count_edges(std::span<const Triangle> triangles, std::size_t vertex_count);

}  // namespace clsdf

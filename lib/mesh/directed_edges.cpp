#include "mesh/directed_edges.hpp"

#include "polyhedra/parallel.hpp"

#include <algorithm>
#include <atomic>

namespace clsdf {

namespace {

/// Calls visit(lower, higher) for the triangle's edges of that direction.
template <typename Visit>
void for_each_edge(const Triangle& triangle, DirectedEdges::Direction direction, const Visit& visit) {
    if (has_repeated_vertex(triangle)) return;
    for (std::size_t k = 0; k < 3; ++k) {
        std::uint32_t lower = triangle[k];
        std::uint32_t higher = triangle[(k + 1) % 3];
        if (direction == DirectedEdges::Direction::to_lower) std::swap(lower, higher);
        if (lower < higher) visit(lower, higher);
    }
}

std::size_t take_one(std::size_t& count) {
    return std::atomic_ref(count).fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

bool has_repeated_vertex(const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

DirectedEdges::DirectedEdges(std::span<const Triangle> triangles, std::size_t vertex_count, Direction direction)
    : start_(vertex_count + 2) {
    // Filed one place further on, so that filling turns each list's start into the next one's.
    polyhedra::for_each_index(triangles.size(), [&](std::size_t t) {
        for_each_edge(triangles[t], direction,
                      [&](std::uint32_t lower, std::uint32_t) { take_one(start_[lower + 2]); });
    });
    for (std::size_t v = 2; v < start_.size(); ++v) start_[v] += start_[v - 1];
    higher_.resize(start_.back());
    polyhedra::for_each_index(triangles.size(), [&](std::size_t t) {
        for_each_edge(triangles[t], direction, [&](std::uint32_t lower, std::uint32_t higher) {
            higher_[take_one(start_[lower + 1])] = higher;
        });
    });
    start_.pop_back();
    // Threads race for the places of a list: only sorted is it the same on every run.
    polyhedra::for_each_index(vertex_count, [&](std::size_t v) {
        std::sort(higher_.begin() + static_cast<std::ptrdiff_t>(start_[v]),
                  higher_.begin() + static_cast<std::ptrdiff_t>(start_[v + 1]));
    });
}

}  // namespace clsdf

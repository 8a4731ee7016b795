#include "mesh/directed_edges.hpp"

#include "core/parallel.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <numeric>
#include <utility>

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

}  // namespace

bool has_repeated_vertex(const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

DirectedEdges::DirectedEdges(std::span<const Triangle> triangles, std::size_t vertex_count, Direction direction)
    : start_(vertex_count + 2) {
    // Each task looks at all triangles and files the edges of its own vertices, so threads share no counters. Both
    // directions are filed at once. More tasks would be limited by memory bandwidth.
    constexpr int most_tasks = 8;
    const auto tasks = static_cast<std::size_t>(std::clamp(tbb::this_task_arena::max_concurrency() / 2, 1, most_tasks));
    const auto for_each_edge_of_all = [&](const auto& visit) {
        tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
            const std::size_t begin = vertex_count * task / tasks;
            const std::size_t end = vertex_count * (task + 1) / tasks;
            for (const Triangle& triangle : triangles)
                for_each_edge(triangle, direction, [&](std::uint32_t lower, std::uint32_t higher) {
                    if (lower >= begin && lower < end) visit(lower, higher);
                });
        });
    };
    // Counts are stored one element further on: after the fill pass each entry is the start of its list.
    for_each_edge_of_all([&](std::uint32_t lower, std::uint32_t) { ++start_[lower + 2]; });
    std::inclusive_scan(start_.begin(), start_.end(), start_.begin());
    higher_.resize(start_.back());
    for_each_edge_of_all([&](std::uint32_t lower, std::uint32_t higher) { higher_[start_[lower + 1]++] = higher; });
    start_.pop_back();
    for_each_index(vertex_count, [&](std::size_t v) {
        std::sort(higher_.begin() + static_cast<std::ptrdiff_t>(start_[v]),
                  higher_.begin() + static_cast<std::ptrdiff_t>(start_[v + 1]));
    });
}

}  // namespace clsdf

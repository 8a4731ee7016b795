#pragma once

#include "core/uninitialized_vector.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// The directed edges of triangles, by the lower of the two vertex indices: those that run from it, or those that run
/// to it. Triangles with repeated vertices have none.
class DirectedEdges {
public:
    enum class Direction { from_lower, to_lower };

    DirectedEdges(std::span<const Triangle> triangles, std::size_t vertex_count, Direction direction);

    /// The higher vertices, sorted, each as often as a triangle uses the edge.
    std::span<const std::uint32_t> at(std::size_t lower) const {
        return std::span(higher_).subspan(start_[lower], start_[lower + 1] - start_[lower]);
    }

private:
    std::vector<std::size_t> start_;  // for each vertex, its begin in higher_; then the end of the last
    UninitializedVector<std::uint32_t> higher_;
};

bool has_repeated_vertex(const Triangle& triangle);

}  // namespace clsdf

#pragma once

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// A corner of a triangle: the triangle at `face` of the list, and which of its vertices, 0 to 2.
struct Corner {
    std::uint32_t face;
    std::uint32_t vertex;

    friend auto operator<=>(const Corner&, const Corner&) = default;
};

constexpr std::uint32_t next_of_three(std::uint32_t k) {
    return k == 2 ? 0 : k + 1;
}
constexpr std::uint32_t previous_of_three(std::uint32_t k) {
    return k == 0 ? 2 : k - 1;
}

/// The corners that meet at each vertex, by face.
class OneRings {
public:
    /// Throws Error(unsupported) for 2^30 triangles or more.
    OneRings(std::span<const Triangle> triangles, std::size_t vertex_count);

    std::size_t vertex_count() const { return start_.size() - 1; }

    std::size_t size(std::size_t vertex) const { return start_[vertex + 1] - start_[vertex]; }

    Corner corner(std::size_t vertex, std::size_t i) const {
        const std::uint32_t packed = corners_[start_[vertex] + i];
        return {packed >> 2, packed & 3};
    }

private:
    std::vector<std::uint32_t> start_;    // of each vertex in corners_, and the end of the last
    std::vector<std::uint32_t> corners_;  // 4 face + vertex of the face
};

}  // namespace clsdf::polyhedra

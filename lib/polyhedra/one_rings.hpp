#pragma once

#include "polyhedra/uninitialized_vector.hpp"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// A corner of a triangle, and the edge of the triangle that begins there.
struct Corner {
    std::uint32_t face;    ///< place of the triangle in the list
    std::uint32_t vertex;  ///< which of its vertices, 0 to 2

    std::uint32_t packed() const { return face << 2 | vertex; }
    static Corner unpack(std::uint32_t packed) { return {packed >> 2, packed & 3}; }
};

// Read from a word of three pairs of bits: which of three an edge is cannot be predicted, and a wrong guess costs more
// than all the rest.
constexpr std::uint32_t next_of_three(std::uint32_t k) {
    return 0b00'10'01U >> 2 * k & 3;
}
constexpr std::uint32_t previous_of_three(std::uint32_t k) {
    return 0b01'00'10U >> 2 * k & 3;
}

/// The corners that meet at each vertex, by face.
class OneRings {
public:
    /// Throws Error(unsupported) for 2^30 triangles or more.
    OneRings(std::span<const Triangle> triangles, std::size_t vertex_count, ScratchMemory* scratch = nullptr);

    std::size_t vertex_count() const { return start_.size() - 1; }

    std::size_t size(std::size_t vertex) const { return start_[vertex + 1] - start_[vertex]; }

    Corner corner(std::size_t vertex, std::size_t i) const { return Corner::unpack(corners_[start_[vertex] + i]); }

    /// The i of a corner at the vertex.
    std::size_t place(std::size_t vertex, const Corner& corner) const {
        const auto begin = corners_.begin() + start_[vertex];
        const auto end = corners_.begin() + start_[vertex + 1];
        return static_cast<std::size_t>(std::lower_bound(begin, end, corner.packed()) - begin);
    }

    /// Whether a corner is the first of its vertex.
    bool is_first(const Corner& corner) const { return (first_[corner.face] >> corner.vertex & 1) != 0; }

private:
    std::vector<std::uint32_t> start_;            // of each vertex in corners_, and the end of the last
    UninitializedVector<std::uint32_t> corners_;  // packed
    UninitializedVector<std::uint8_t> first_;     // by face, a bit for each of its corners
};

/// Calls f(vertex) for every vertex that the list first names between its places `begin` and `end`, in that order:
/// neighbours in the list are neighbours in memory.
template <typename Function>
void for_each_vertex(std::span<const Triangle> triangles, const OneRings& rings, std::size_t begin, std::size_t end,
                     const Function& f) {
    for (std::size_t face = begin; face != end; ++face)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (rings.is_first({static_cast<std::uint32_t>(face), k})) f(triangles[face][k]);
}

}  // namespace clsdf::polyhedra

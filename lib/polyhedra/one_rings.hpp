#pragma once

#include "core/uninitialized_vector.hpp"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

struct OrderedFaces;

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

/// The largest number of faces whose corners can be packed.
inline constexpr std::size_t most_faces = (std::size_t{1} << 30) - 1;
/// The count; throws Error(unsupported) for more.
std::size_t checked_face_count(std::size_t count);

/// The corners that meet at each vertex, by face.
class OneRings {
public:
    /// Throws Error(unsupported) for more than most_faces.
    OneRings(std::span<const Triangle> triangles, std::size_t vertex_count);

    /// The same, but faster: the sub-ranges of OrderedFaces let each core file nearly all corners of its own faces.
    explicit OneRings(const OrderedFaces& faces);

    std::size_t vertex_count() const { return start_.size() - 1; }

    std::size_t size(std::size_t vertex) const { return start_[vertex + 1] - start_[vertex]; }

    /// The place of a vertex's first corner among the corners of all vertices.
    std::size_t start(std::size_t vertex) const { return start_[vertex]; }

    Corner corner(std::size_t vertex, std::size_t i) const { return Corner::unpack(corners_[start_[vertex] + i]); }

    /// The i of a corner at the vertex.
    std::size_t place(std::size_t vertex, const Corner& corner) const {
        const auto begin = corners_.begin() + start_[vertex];
        const auto end = corners_.begin() + start_[vertex + 1];
        return static_cast<std::size_t>(std::lower_bound(begin, end, corner.packed()) - begin);
    }

    /// Whether a corner is the first of the vertex.
    bool is_first(std::size_t vertex, const Corner& corner) const {
        return corners_[start_[vertex]] == corner.packed();
    }

    std::size_t bytes() const { return (start_.size() + corners_.size()) * sizeof(std::uint32_t); }

private:
    class Filing;

    UninitializedVector<std::uint32_t> start_;    // of each vertex in corners_, and the end of the last
    UninitializedVector<std::uint32_t> corners_;  // packed
};

}  // namespace clsdf::polyhedra

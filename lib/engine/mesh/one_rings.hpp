#pragma once

#include <clsdf/mesh.hpp>

#include "core/kept_array.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

/// The largest number of faces whose corners can be packed.
inline constexpr std::size_t most_faces = (std::size_t{1} << 30) - 1;
/// The count; throws Error(unsupported) for more.
std::size_t checked_face_count(std::size_t count);

/// A corner of a triangle, and the edge of the triangle that begins there.
struct Corner {
    std::uint32_t face;    ///< place of the triangle in the list
    std::uint32_t vertex;  ///< which of its vertices, 0 to 2

    std::uint32_t packed() const { return face << 2 | vertex; }
    static Corner unpack(std::uint32_t packed) { return {packed >> 2, packed & 3}; }
};

// Without branches: an edge's number is random, so a branch on it would be mispredicted.
constexpr std::uint32_t next_of_three(std::uint32_t k) {
    return 0b00'10'01U >> 2 * k & 3;
}
constexpr std::uint32_t previous_of_three(std::uint32_t k) {
    return 0b01'00'10U >> 2 * k & 3;
}

/// The corners that meet at each vertex, by face.
class OneRings {
public:
    /// Throws Error(unsupported) for more than most_faces.
    OneRings(std::span<const Triangle> triangles, std::size_t vertex_count);
    /// start: of each vertex in `corners`, packed, and the end of the last.
    OneRings(KeptArray<std::uint32_t> start, KeptArray<std::uint32_t> corners)
        : start_(std::move(start)), corners_(std::move(corners)) {}

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

    /// As the constructor takes them.
    const KeptArray<std::uint32_t>& starts() const { return start_; }
    const KeptArray<std::uint32_t>& corners() const { return corners_; }

    std::size_t host_bytes() const { return start_.host_bytes() + corners_.host_bytes(); }

private:
    KeptArray<std::uint32_t> start_;    // of each vertex in corners_, and the end of the last
    KeptArray<std::uint32_t> corners_;  // packed
};

/// To each edge that leaves a vertex, those that run along it: of up to `most_faces` faces, because all pairs of them
/// are compared.
struct RingMatches {
    static constexpr std::size_t most_faces = 16;
    using Numbers = std::array<std::uint32_t, most_faces>;

    Numbers other;  ///< the last of the edges that arrive
    Numbers arriving;
    Numbers leaving;
};
/// `next`, `previous`: of each face, the vertices at the ends of its edges that leave the vertex, and that arrive
/// there.
RingMatches match_ring(const RingMatches::Numbers& next, const RingMatches::Numbers& previous, std::size_t count);

/// Whether all edges at a vertex have two faces that run along them in opposite directions; false, too, if it has more
/// than RingMatches::most_faces. Calls set_pair(corner, other) for the edge that leaves by each corner, which arrives
/// by the corner `other` of the other face. The pairs have no meaning if the result is false.
template <typename Function>
bool pair_ring(std::span<const Triangle> triangles, const OneRings& rings, std::size_t vertex,
               const Function& set_pair) {
    const std::size_t count = rings.size(vertex);
    if (count > RingMatches::most_faces) return false;
    std::array<Corner, RingMatches::most_faces> corners;  // not cleared: this is done for every vertex
    RingMatches::Numbers next{}, previous{};
    for (std::size_t i = 0; i < count; ++i) {
        corners[i] = rings.corner(vertex, i);
        const Triangle& triangle = triangles[corners[i].face];
        next[i] = triangle[next_of_three(corners[i].vertex)];
        previous[i] = triangle[previous_of_three(corners[i].vertex)];
    }
    const RingMatches matches = match_ring(next, previous, count);
    bool are_paired = true;
    for (std::size_t i = 0; i < count; ++i) {
        const Corner& other = corners[matches.other[i]];
        // A face with a vertex twice arrives along the edge that it leaves by.
        are_paired &= matches.arriving[i] == 1 && matches.leaving[i] == 1 && other.face != corners[i].face;
        set_pair(corners[i], other);
    }
    return are_paired;
}

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

}  // namespace clsdf

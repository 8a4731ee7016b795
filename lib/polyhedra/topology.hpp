#pragma once

#include <clsdf/mesh.hpp>

#include "core/large_memory.hpp"
#include "polyhedra/face_order.hpp"

#include <algorithm>
#include <array>
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

/// Properties of an edge, as its end vertices see it; several may hold.
enum EdgeMark : std::uint8_t {
    edge_convex = 1,        ///< of two faces that run along it in opposite directions, by the exact orientation of
    edge_concave = 2,       ///< the coordinates as given; neither: flat
    edge_open = 4,          ///< one face, or two folded onto each other: no plane cuts there
    edge_non_manifold = 8,  ///< three faces or more; in a part of a mesh, those of the whole count
    edge_unoriented =
        16,            ///< two faces that run along it the same way: what is convex for one is concave for the other
    edge_at_box = 32,  ///< one of its faces is so degenerate that its polyhedron is a box
    edge_folded = 64,  ///< open because its two faces are folded onto each other
};

/// Data of the edges of a face; edge k runs from the face's vertex k to the next.
struct FaceEdges {
    std::array<std::uint32_t, 3> across;  ///< the other face's edge, packed, if there is exactly one other face
    std::array<std::uint8_t, 3> marks;    ///< EdgeMark
};

inline bool has_mark(std::span<const FaceEdges> faces, const Corner& edge, EdgeMark mark) {
    return (faces[edge.face].marks[edge.vertex] & mark) != 0;
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

/// The faces that meet at each edge.
struct PairedEdges {
    /// For each face, the data that follow from the vertices' indices: edge_open, edge_non_manifold, edge_unoriented,
    /// edge_at_box of an edge from a vertex to itself, and the faces across.
    UninitializedVector<FaceEdges> faces;
    std::vector<std::uint32_t> non_manifold_ends;  ///< lower ends of edges with edge_non_manifold, ascending

    bool is_non_manifold(std::size_t face) const {
        const auto& [a, b, c] = faces[face].marks;
        return ((a | b | c) & edge_non_manifold) != 0;
    }
};

PairedEdges pair_edges(std::span<const Triangle> triangles, const OneRings& rings);

/// The faces around a vertex all of whose edges there have two faces: closed fans, each in the cyclic order in which
/// its faces share edges. Face i of a fan lies between the edges to the neighbours i and i + 1.
class VertexFans {
public:
    struct Face {
        Corner corner;
        std::uint32_t neighbour;  ///< at the edge shared with the face before
        bool forward;             ///< in the face's own order that neighbour comes after the vertex
    };

    /// Orders the corners at `vertex`.
    void build(std::span<const Triangle> triangles, std::span<const FaceEdges> faces, const OneRings& rings,
               std::size_t vertex);

    std::size_t fan_count() const { return starts_.size() - 1; }
    /// Index of the first face of a fan; that of the one after the last is the number of faces.
    std::size_t start(std::size_t fan) const { return starts_[fan]; }

    /// Fan after fan.
    std::span<const Face> faces() const { return faces_; }

private:
    void walk(std::span<const Triangle> triangles, std::span<const FaceEdges> faces, std::size_t vertex, Corner first);

    std::vector<std::uint8_t> walked_;  // by place in the ring
    std::vector<Face> faces_;
    std::vector<std::size_t> starts_;
};

/// The data that follow from a mesh's triangles. The order of the faces also depends on the first positions of the
/// vertices; later positions do not change it.
struct MeshTopology {
    UninitializedVector<std::uint32_t> order;  ///< the mesh's index of each face, in Morton order
    OrderedFaces faces;
    OneRings rings;
    PairedEdges edges;

    /// Throws Error(unsupported) for 2^30 faces or more.
    explicit MeshTopology(const Mesh& mesh);
    /// In another order: the mesh's index of each face.
    MeshTopology(const Mesh& mesh, UninitializedVector<std::uint32_t> order);

    std::size_t bytes() const;
};

}  // namespace clsdf::polyhedra

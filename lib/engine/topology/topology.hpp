#pragma once

#include <clsdf/mesh.hpp>

#include "core/kept_array.hpp"
#include "face_edges.h"
#include "mesh/one_rings.hpp"
#include "topology/face_order.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::engine {

/// Properties of an edge, as its end vertices see it; several may hold.
enum EdgeMark : std::uint8_t {
    edge_convex =
        CLSDF_MARK_CONVEX,  ///< of two faces that run along it in opposite directions, by the exact orientation of
    edge_concave = CLSDF_MARK_CONCAVE,  ///< the coordinates as given; neither: flat
    edge_open = CLSDF_MARK_OPEN,        ///< one face, or two folded onto each other: no plane cuts there
    edge_non_manifold =
        CLSDF_MARK_NON_MANIFOLD,              ///< three faces or more; in a part of a mesh, those of the whole count
    edge_unoriented = CLSDF_MARK_UNORIENTED,  ///< two faces that run along it the same way: what is convex for one is
                                              ///< concave for the other
    edge_at_box = CLSDF_MARK_AT_BOX,          ///< one of its faces is so degenerate that its polyhedron is a box
    edge_folded = CLSDF_MARK_FOLDED,          ///< open because its two faces are folded onto each other
};

/// Data of the edges of a face; edge k runs from the face's vertex k to the next.
struct FaceEdges {
    std::array<std::uint32_t, 3> across;  ///< the other face's edge, packed, if there is exactly one other face
    std::array<std::uint8_t, 3> marks;    ///< EdgeMark
    std::uint8_t unused;                  ///< 0: bytes that are archived have no padding
};

inline bool has_mark(std::span<const FaceEdges> faces, const Corner& edge, EdgeMark mark) {
    return (faces[edge.face].marks[edge.vertex] & mark) != 0;
}

/// The faces that meet at each edge.
struct PairedEdges {
    /// For each face, the data that follow from the vertices' indices: edge_open, edge_non_manifold, edge_unoriented,
    /// edge_at_box of an edge from a vertex to itself, and the faces across.
    KeptArray<FaceEdges> faces;
    std::vector<std::uint32_t> non_manifold_ends;  ///< lower ends of edges with edge_non_manifold, ascending
    bool are_paired = false;  ///< each edge has two faces, which run along it in opposite directions

    bool is_non_manifold(std::size_t face) const {
        const auto& [a, b, c] = faces[face].marks;
        return ((a | b | c) & edge_non_manifold) != 0;
    }
};

PairedEdges pair_edges(std::span<const Triangle> triangles, const OneRings& rings);

/// Goes around a vertex, counter-clockwise, from one of its `count` corners on, and calls f(corner) for each until it
/// returns false. Returns whether all faces there are one closed fan of one orientation.
template <typename Function>
bool walk_fan(std::span<const FaceEdges> faces, const Corner& first, std::size_t count, const Function& f) {
    Corner corner = first;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t arriving = previous_of_three(corner.vertex);
        if (!f(corner) || faces[corner.face].marks[arriving] != 0) return false;
        corner = Corner::unpack(faces[corner.face].across[arriving]);
        if (corner.face == first.face) return i + 1 == count;
    }
    return false;
}

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

/// A mesh among several that are joined: see JoinedMeshes.
struct JoinedPart {
    std::uint32_t face_begin, face_end;  ///< the faces up to the next part are the last one again
    std::uint32_t vertex_end;
};

/// The data that follow from a mesh's triangles. The order of the faces also depends on the first positions of the
/// vertices; later positions do not change it.
struct MeshTopology {
    KeptArray<std::uint32_t> order;  ///< the mesh's index of each face, in Morton order
    OrderedFaces faces;
    OneRings rings;
    PairedEdges edges;
    std::vector<JoinedPart> joined{};  ///< of several meshes; empty for one

    /// Throws Error(unsupported) for 2^30 faces or more.
    explicit MeshTopology(const Mesh& mesh);
    /// In another order: the mesh's index of each face.
    MeshTopology(const Mesh& mesh, KeptArray<std::uint32_t> order);
    /// Of parts that were made elsewhere.
    MeshTopology(KeptArray<std::uint32_t> order_in, OrderedFaces faces_in, OneRings rings_in, PairedEdges edges_in)
        : order(std::move(order_in)),
          faces(std::move(faces_in)),
          rings(std::move(rings_in)),
          edges(std::move(edges_in)) {}

    /// The face itself, or, for one that fills up a group of a joined mesh's records, the face that it repeats.
    std::uint32_t original(std::uint32_t face) const;

    std::size_t host_bytes() const;
};

/// Three of each face: the vertex of the other face that lies opposite to edge k, and which edge of that face it is
/// (CLSDF_OPPOSITE_EDGE). CLSDF_NO_VERTEX for an open edge; CLSDF_UNPAIRED_EDGE for others unless the edge has exactly
/// two faces, of one orientation.
UninitializedVector<std::uint32_t> opposite_words(const MeshTopology& topology);

}  // namespace clsdf::engine

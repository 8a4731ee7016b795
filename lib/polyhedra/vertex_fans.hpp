#pragma once

#include "polyhedra/edges.hpp"
#include "polyhedra/one_rings.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

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

}  // namespace clsdf::polyhedra

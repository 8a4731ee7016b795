#pragma once

#include "polyhedra/frames.hpp"
#include "polyhedra/topology.hpp"

#include <clsdf/papers.hpp>

#include <vector>

namespace clsdf::papers {

using polyhedra::Corner;
using polyhedra::Vector;

/// A mesh whose triangles know each other: no two vertices in use are equal, and no face repeats a vertex. The mesh
/// must outlive it.
class Surface {
public:
    explicit Surface(const Mesh& mesh);

    const Mesh& mesh() const { return *mesh_; }
    const Vec3& position(std::size_t vertex) const { return mesh_->vertices()[vertex]; }

    const std::vector<Triangle>& triangles() const { return triangles_; }
    /// Indices of the triangles in the mesh.
    const std::vector<std::uint32_t>& sources() const { return sources_; }
    /// Of each vertex of the mesh the one that stands for it.
    const std::vector<std::uint32_t>& representatives() const { return representatives_; }
    /// Directions only: lengths are in units of the mesh's longest side.
    const std::vector<polyhedra::TriangleFrame>& frames() const { return frames_; }
    const polyhedra::OneRings& rings() const { return rings_; }

    EdgeKind kind(const Corner& edge) const;
    VertexKind kind(std::size_t vertex, polyhedra::VertexFans& fans) const;

    bool has_pair(const Corner& edge) const;
    /// The other face's edge, where there is exactly one other face.
    Corner across(const Corner& edge) const { return Corner::unpack(edges_[edge.face].across[edge.vertex]); }
    /// Every face's edge between the two vertices of `edge`, which is among them; the lowest first.
    std::vector<Corner> edges_at(const Corner& edge) const;

    /// Of a vertex that is not on a boundary and has manifold edges.
    void build_fans(std::size_t vertex, polyhedra::VertexFans& fans) const;

private:
    /// Number of faces of one open fan whose edges are oriented alike.
    std::size_t open_fan_size(std::size_t vertex) const;
    std::uint8_t marks(const Corner& edge) const { return edges_[edge.face].marks[edge.vertex]; }

    const Mesh* mesh_;
    std::vector<std::uint32_t> representatives_;
    std::vector<std::uint32_t> sources_;
    std::vector<Triangle> triangles_;
    std::vector<polyhedra::TriangleFrame> frames_;
    polyhedra::OneRings rings_;
    UninitializedVector<polyhedra::FaceEdges> edges_;
};

}  // namespace clsdf::papers

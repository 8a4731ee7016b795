#pragma once

#include "frusta/frames.hpp"
#include "topology/topology.hpp"

#include <clsdf/papers.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::papers {

using engine::Vector;

/// A mesh whose triangles know each other: no two vertices in use are equal, and no face repeats a vertex. The mesh
/// must outlive it.
class MeshSurface {
public:
    explicit MeshSurface(const Mesh& mesh);

    const Mesh& mesh() const { return *mesh_; }
    const Vec3& position(std::size_t vertex) const { return mesh_->vertices()[vertex]; }

    const std::vector<Triangle>& triangles() const { return triangles_; }
    /// Indices of the triangles in the mesh.
    const std::vector<std::uint32_t>& sources() const { return sources_; }
    /// For each vertex of the mesh, the one that stands for it.
    const std::vector<std::uint32_t>& representatives() const { return representatives_; }
    /// Directions only: lengths are in units of the mesh's longest side.
    const std::vector<engine::TriangleFrame>& frames() const { return frames_; }
    const OneRings& rings() const { return rings_; }

    EdgeKind kind(const Corner& edge) const;
    VertexKind kind(std::size_t vertex, engine::VertexFans& fans) const;

    bool has_pair(const Corner& edge) const;
    /// The other face's edge, if there is exactly one other face.
    Corner across(const Corner& edge) const { return Corner::unpack(edges_[edge.face].across[edge.vertex]); }
    /// Every face's edge between the two vertices of `edge`, which is among them; the lowest first.
    std::vector<Corner> edges_at(const Corner& edge) const;

    /// The vertex is not on a boundary and has manifold edges.
    void build_fans(std::size_t vertex, engine::VertexFans& fans) const;

private:
    /// Number of faces of one open fan whose edges are oriented alike.
    std::size_t open_fan_size(std::size_t vertex) const;
    std::uint8_t marks(const Corner& edge) const { return edges_[edge.face].marks[edge.vertex]; }

    const Mesh* mesh_;
    std::vector<std::uint32_t> representatives_;
    std::vector<std::uint32_t> sources_;
    std::vector<Triangle> triangles_;
    std::vector<engine::TriangleFrame> frames_;
    OneRings rings_;
    KeptArray<engine::FaceEdges> edges_;
};

/// Points beyond the bisector planes of all faces of a fan, in the same rotational sense, are in none of its polyhedra
/// (Peikert & Sigg, section 3.2). The planes pass through the vertex, so they form a cone; its antipode is the one of
/// the other sense.
/// A vertex with a closed fan of faces around it, counter-clockwise seen from outside: face i lies between neighbours i
/// and i + 1.
struct Fan {
    Vec3 vertex{};
    std::vector<Vec3> neighbours;
    std::vector<std::uint8_t> is_flat;  ///< the faces i - 1 and i, at the edge to neighbour i, lie in one plane

    std::size_t size() const { return neighbours.size(); }
    std::size_t before(std::size_t i) const { return i == 0 ? size() - 1 : i - 1; }
    std::size_t after(std::size_t i) const { return i + 1 == size() ? 0 : i + 1; }
};

/// The planes at a fan: one at each edge, or those of the faces.
enum class PlaneKind { bisector, face };

/// The direction A_i x A_j times `weight`, A_i and A_j the normals of two planes.
struct PlaneLine {
    std::size_t i;
    std::size_t j;
    double weight;
};

/// Signs that the bisector planes of one fan decide, each exact for the coordinates as given: by interval arithmetic,
/// and, if that leaves one open, by numbers with square roots. To be used, and destroyed, by the thread that made it.
class FanSigns {
public:
    /// The fan must outlive it.
    explicit FanSigns(const Fan& fan);
    ~FanSigns();

    const Fan& fan() const { return fan_; }

    /// On which side of bisector plane k the direction A_i x A_j lies: 1, -1, or 0 on the plane or if the planes i
    /// and j are parallel. The normal A_k points out of face k.
    int side(std::size_t i, std::size_t j, std::size_t k);

    /// The same of the faces' planes, moved to the vertex, with their normals.
    int side_of_face(std::size_t i, std::size_t j, std::size_t k);

    /// A power of two by which the line in which two planes of a kind meet is about as long as others.
    double line_weight(PlaneKind kind, std::size_t i, std::size_t j) const;

    /// Chooses a direction for side_of_direction(): the sum of lines in which planes of a kind meet.
    void set_direction(PlaneKind kind, std::span<const PlaneLine> lines);

    /// On which side of plane k of that kind the chosen direction lies: 1 where the normal points, -1, or 0 on it.
    int side_of_direction(std::size_t k);

    /// Whether face i is seen from its front (1), from its back (-1) or edgewise (0) along the average of the faces'
    /// unit normals.
    int facing(std::size_t i);

    std::size_t decisions() const { return decisions_; }
    std::size_t exact_decisions() const { return exact_decisions_; }

private:
    struct Filter;
    struct Exact;
    struct Direction;

    /// The sign of what `value` computes from the planes in either arithmetic.
    template <typename Value>
    int decide(const Value& value);
    const Exact& exact();

    const Fan& fan_;
    std::unique_ptr<Filter> filter_;
    std::unique_ptr<Exact> exact_;  // made when it is needed
    std::unique_ptr<Direction> direction_;
    std::size_t decisions_ = 0;
    std::size_t exact_decisions_ = 0;
};

/// The fan of a vertex that has one, closed and of faces oriented alike. `fans` is memory to work in.
Fan fan_at(const MeshSurface& surface, std::size_t vertex, engine::VertexFans& fans);

/// A line in which the bisector planes i and i + 1 meet, and which lies strictly on one side of all other planes.
struct FailingLine {
    std::size_t i;
    int direction;  ///< 1 where A_i x A_(i+1) points beyond the planes of all faces in the sense of increasing i, or -1
};

/// The published test: it passes if there are none.
std::vector<FailingLine> failing_lines(FanSigns& signs);

/// The complete test: whether there are points strictly beyond all planes. The cone of such points, if there are any,
/// is spanned by lines in which two planes meet, not necessarily successive ones.
bool has_gap(FanSigns& signs);

/// Whether there is a direction along which every face is seen from its front. False also if all normals lie in one
/// plane.
bool has_view(FanSigns& signs);

/// Indices of the faces that are not seen from their front along the average normal.
std::vector<std::size_t> flipped_faces(FanSigns& signs);

}  // namespace clsdf::papers

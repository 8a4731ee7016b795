#pragma once

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/edges.hpp"
#include "polyhedra/fan_batch.hpp"
#include "polyhedra/lateral_planes.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The faces around a vertex from its first one on, in the order in which they share edges. Each edge has two faces
/// there, of one orientation.
inline void walk_first_fan(std::span<const FaceEdges> edges, const OneRings& rings, std::size_t vertex,
                           std::vector<Corner>& fan) {
    const Corner first = rings.corner(vertex, 0);
    fan.clear();
    Corner corner = first;
    do {
        fan.push_back(corner);
        corner = Corner::unpack(edges[corner.face].across[previous_of_three(corner.vertex)]);
    } while (corner.face != first.face);
}

/// Takes vertices out whose normals their faces surely cover, by a quick test: nearly all.
class FanScreen {
public:
    FanScreen(std::span<const FaceEdges> edges, const OneRings& rings, double margin)
        : edges_(edges), rings_(rings), margin_(margin) {}

    /// A vertex all of whose edges have two faces, of one orientation. `planes` has plane(edge) of those faces' edges.
    template <typename Planes>
    void add(const Planes& planes, std::uint32_t vertex) {
        walk_first_fan(edges_, rings_, vertex, fan_);
        if (fan_.size() > FanBatch::most_faces) {
            left_.push_back(vertex);
            return;
        }
        FanBatch& batch = batches_[fan_.size()];
        batch.add(planes, vertex, fan_);
        if (batch.is_full()) test(batch);
    }

    /// To be left in any case.
    void leave(std::uint32_t vertex) { left_.push_back(vertex); }

    /// Ends with what has been added. Returns the vertices that are left.
    const std::vector<std::uint32_t>& finish() {
        for (FanBatch& batch : batches_) test(batch);
        return left_;
    }

private:
    void test(FanBatch& batch) {
        if (batch.size() == 0) return;
        FanBatch::Answers are_covered;
        batch.ask(margin_, are_covered);
        for (std::size_t i = 0; i < batch.size(); ++i)
            if (are_covered[i] == 0) left_.push_back(batch.vertex(i));
        batch.clear();
    }

    std::span<const FaceEdges> edges_;
    const OneRings& rings_;
    double margin_;
    std::array<FanBatch, FanBatch::most_faces + 1> batches_;  // by number of faces
    std::vector<Corner> fan_;
    std::vector<std::uint32_t> left_;
};

enum VertexMark : std::uint8_t {
    vertex_saddle = 1,  ///< convex and concave edges meet there
    vertex_gap = 2,     ///< directions may be left out by the polyhedra of all its faces: it needs a point site
};

/// Marks of the edges at a vertex.
struct EdgesAround {
    std::uint8_t marks = 0;

    EdgesAround() = default;
    EdgesAround(std::span<const FaceEdges> edges, const OneRings& rings, std::size_t vertex) {
        for (std::size_t i = 0; i < rings.size(vertex); ++i) add(edges, rings.corner(vertex, i));
    }

    /// The two of a face.
    void add(std::span<const FaceEdges> edges, const Corner& corner) {
        const FaceEdges& face = edges[corner.face];
        marks |= face.marks[corner.vertex];
        marks |= face.marks[previous_of_three(corner.vertex)];
    }

    bool has(std::uint8_t mark) const { return (marks & mark) != 0; }
    bool are_mixed() const { return has(edge_convex) && has(edge_concave); }
    std::uint8_t vertex_mark() const { return are_mixed() ? vertex_saddle : 0; }
    /// Each has two faces, of one orientation.
    bool are_plain() const { return !has(edge_at_box | edge_non_manifold | edge_open | edge_unoriented); }
};

/// Marks vertices, and finds most of those that surely need no point site, while the frames of their faces are at hand.
class GapScreen {
public:
    /// `first_vertices`: OrderedFaces::first_vertices
    GapScreen(std::span<const std::uint32_t> first_vertices, std::span<const FaceEdges> edges, const OneRings& rings,
              double margin, std::span<std::uint8_t> marks)
        : first_vertices_(first_vertices), edges_(edges), rings_(rings), marks_(marks), fans_(edges, rings, margin) {}

    /// The vertices that the stretch is the first to name. Its slopes are leaned.
    void look_at(const EdgeSlopes& stretch);

    /// The vertices that are left to find_gaps(): also those with faces outside their stretch, which have no marks yet.
    const std::vector<std::uint32_t>& finish() { return fans_.finish(); }

private:
    std::span<const std::uint32_t> first_vertices_;
    std::span<const FaceEdges> edges_;
    const OneRings& rings_;
    std::span<std::uint8_t> marks_;
    FanScreen fans_;
};

/// A direction that is rejected by less than this lies within a quarter of the slack of the polyhedron (docs/method.md,
/// 'Gaps at saddle vertices').
///
/// A quarter of the slack 1e-3 + 2e-5 d is d times this or more, for every distance d in units.
inline constexpr double rejection_margin = 5e-6;

/// Sets the marks of `vertices`. A vertex without vertex_gap has its whole normal cone in its faces' polyhedra, widened
/// by a quarter of the slack.
void find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
               const FramePlanes& planes, double margin, std::span<const std::uint32_t> vertices,
               std::span<std::uint8_t> marks);

}  // namespace clsdf::polyhedra

#pragma once

#include "polyhedra/lateral_planes.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/vector.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace clsdf::polyhedra {

/// Closed fans of equally many faces, all of one orientation, as many at a time as a processor's vectors hold: whether
/// it is certain that their faces cover all directions (docs/method.md, 'Gaps at saddle vertices').
class FanBatch {
public:
    static constexpr std::size_t most_faces = 12;

    bool is_full() const { return size_ == lanes; }
    std::size_t size() const { return size_; }
    std::uint32_t vertex(std::size_t i) const { return vertices_[i]; }
    void clear() { size_ = 0; }

    /// `fan`: the vertex' corners in their cyclic order, counter-clockwise; of all fans equally many. `planes` has
    /// plane(edge) of every face's edges.
    template <typename Planes>
    void add(const Planes& planes, std::uint32_t vertex, std::span<const Corner> fan) {
        const std::size_t i = size_++;
        vertices_[i] = vertex;
        face_count_ = fan.size();
        for (std::size_t f = 0; f < fan.size(); ++f) {
            const LateralPlane leaving = planes.plane(fan[f]);
            normals_[f].set(i, leaving.normal);
            set(edges_[0][f], i, leaving);
            set(edges_[1][f], i, planes.plane({fan[f].face, previous_of_three(fan[f].vertex)}));
        }
    }

    /// For each fan, whether it is certain that its faces do not all reject one direction by the margin, each at its
    /// edge that leaves the vertex, or each at the edge that arrives. The answer is no if the test is not cheap, which
    /// is rare if few faces meet.
    using Answers = std::array<std::int32_t, lanes>;
    void ask(double margin, Answers& are_covered) const;

private:
    /// One of the two edges at the vertex of a face.
    struct Edge {
        LaneVectors inward;
        std::array<float, lanes> above;  ///< slopes
        std::array<float, lanes> below;
    };
    using Edges = std::array<Edge, most_faces>;

    static void set(Edge& edge, std::size_t i, const LateralPlane& plane) {
        edge.inward.set(i, plane.inward);
        edge.above[i] = plane.above;
        edge.below[i] = plane.below;
    }

    std::size_t size_ = 0;
    std::size_t face_count_ = 0;
    std::array<std::uint32_t, lanes> vertices_{};
    // Lanes beyond the size are padding; their results are discarded.
    std::array<LaneVectors, most_faces> normals_{};
    std::array<Edges, 2> edges_{};  // leaving the vertex, arriving
};

}  // namespace clsdf::polyhedra

#pragma once

#include "core/parallel.hpp"
#include "core/uninitialized_vector.hpp"
#include "polyhedra/edge_batches.hpp"
#include "polyhedra/edges.hpp"
#include "polyhedra/lateral_planes.hpp"
#include "polyhedra/mesh_topology.hpp"
#include "polyhedra/side_of_plane.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The slopes at edges where three faces or more meet, for EdgeSlopes; sets their places (FaceEdges::across) and
/// edge_at_box.
std::vector<EdgeSlope> non_manifold_slopes(const MeshFaces& faces, const OneRings& rings, PairedEdges& edges,
                                           float open);

/// The half wedges of every face: each face at an edge takes the angle up to the bisector with the next face on that
/// side, or the whole wedge if there is none. Measures a sub-range of the faces at a time, which fits the caches. Faces
/// beyond its borders are measured again by their own sub-range, to the same bits.
class EdgeSlopes {
public:
    /// `edges` as pair_edges() leaves them; the stretches add the other marks and the bases.
    EdgeSlopes(const MeshFaces& faces, std::span<FaceEdges> edges, std::span<const EdgeSlope> of_non_manifold,
               float open)
        : faces_(faces), edges_(edges), of_non_manifold_(of_non_manifold), open_(open) {}

    void measure(std::size_t begin, std::size_t end);

    std::size_t begin() const { return begin_; }
    std::size_t end() const { return begin_ + size_; }

    /// The frame of a face of the sub-range.
    const TriangleFrame& frame(std::size_t face) const { return frames_[face - begin_]; }
    FaceSlopes& slopes(std::size_t face) { return slopes_[face - begin_]; }
    LateralPlane plane(const Corner& edge) const {
        const TriangleFrame& frame = frames_[edge.face - begin_];
        const FaceSlopes& slopes = slopes_[edge.face - begin_];
        return {frame.normal, frame.inwards[edge.vertex], slopes.above[edge.vertex], slopes.below[edge.vertex]};
    }

private:
    /// An edge of two faces, as each of them has it: by their places in frames_. The first is of the stretch, the
    /// second may lie beyond its border, where the first is the second: what is measured has the same bits either way.
    struct Wedge {
        Corner first;
        Corner second;
    };
    struct Measured {
        Wedge faces;
        bool folded;
        float slope;
    };

    void find_wedges();
    void measure_frames();
    void set_alone(const Corner& edge);
    void measure_wedges(std::span<const Wedge> wedges);
    void set_usual(const Measured& wedge, int side);
    void set_any(const Measured& wedge, int side);
    void answer_questions();

    std::uint8_t& marks(const Corner& edge) { return edges_[begin_ + edge.face].marks[edge.vertex]; }
    void set(const Corner& edge, const EdgeSlope& slope) {
        slopes_[edge.face].above[edge.vertex] = slope.above;
        slopes_[edge.face].below[edge.vertex] = slope.below;
    }
    OppositeVertex opposite_vertex(const Wedge& wedge) const;

    MeshFaces faces_;
    std::span<FaceEdges> edges_;
    std::span<const EdgeSlope> of_non_manifold_;
    float open_;

    std::size_t begin_ = 0;
    std::size_t size_ = 0;
    UninitializedVector<TriangleFrame> frames_;  // of the stretch, then of the faces beyond its borders
    std::vector<FaceSlopes> slopes_;
    std::vector<Triangle> beyond_;       // the faces beyond the borders, once for each edge there
    UninitializedVector<Wedge> wedges_;  // each once
    std::vector<Corner> alone_;          // edges without exactly one other face
    WedgeBatch batch_;
    WedgeBatch::Results measured_{};
    std::vector<Measured> questions_;  // on which side the second face lies: the frames do not tell
    PlaneSides sides_;
};

/// Calls f(stretch) for stretches that cover the faces, on all cores. The stretches are the same on any number of them.
template <typename Function>
void measure_edges(const MeshFaces& faces, std::span<FaceEdges> edges, std::span<const EdgeSlope> of_non_manifold,
                   float open, const Function& f) {
    tbb::enumerable_thread_specific<EdgeSlopes> stretches(
        [&] { return EdgeSlopes(faces, edges, of_non_manifold, open); });
    for_each_stretch(faces.triangles.size(), OrderedFaces::stretch,
                     [&](std::size_t, std::size_t begin, std::size_t end) {
                         EdgeSlopes& stretch = stretches.local();
                         stretch.measure(begin, end);
                         f(stretch);
                     });
}

}  // namespace clsdf::polyhedra

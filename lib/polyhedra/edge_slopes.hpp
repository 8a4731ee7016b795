#pragma once

#include "polyhedra/crowded_edges.hpp"
#include "polyhedra/dihedral.hpp"
#include "polyhedra/face_edges.hpp"
#include "polyhedra/lateral_plane.hpp"
#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/ordered_faces.hpp"
#include "polyhedra/parallel.hpp"
#include "polyhedra/plane_sides.hpp"
#include "polyhedra/uninitialized_vector.hpp"
#include "polyhedra/wedge_batch.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The slope that no point of the band gets past (docs/method.md, 'Leaned frusta'): open * slack >= half_width.
float open_slope(double half_width, double slack);

/// The half wedges of every face: each face at an edge takes the angle up to the bisector with the next face on that
/// side, and the whole wedge where there is none. Measures a stretch of the faces at a time, which stays in the caches;
/// the faces across its borders are measured by their own stretch once more, to the same bits.
class EdgeSlopes {
public:
    /// `edges` as pair_edges() leaves them; the stretches add the other marks and the bases.
    EdgeSlopes(const MeshFaces& faces, std::span<FaceEdges> edges, std::span<const EdgeSlope> crowded, float open)
        : faces_(faces), edges_(edges), crowded_(crowded), open_(open) {}

    void measure(std::size_t begin, std::size_t end);

    std::size_t begin() const { return begin_; }
    std::size_t end() const { return begin_ + size_; }

    /// Of a face of the stretch.
    const TriangleFrame& frame(std::size_t face) const { return frames_[face - begin_]; }
    FaceSlopes& slopes(std::size_t face) { return slopes_[face - begin_]; }
    LateralPlane plane(const Corner& edge) const {
        const TriangleFrame& frame = frames_[edge.face - begin_];
        const FaceSlopes& slopes = slopes_[edge.face - begin_];
        return {frame.normal, frame.inwards[edge.vertex], slopes.above[edge.vertex], slopes.below[edge.vertex]};
    }

private:
    /// An edge of a face of the stretch whose other face lies on a side that its frames do not tell. Where that is a
    /// face of the stretch too, the first of them asks for both.
    struct Question {
        std::size_t face;
        std::uint32_t edge;
        bool folded;
        float slope;
    };

    void find_neighbours();
    void measure_frames();
    void set_group(std::size_t first, std::size_t last);
    void set_other(const Question& edge, int side);
    void set_pair(const Question& edge, int side);
    void answer_questions();

    std::size_t place_across(std::size_t face, std::uint32_t edge) const { return across_[3 * face + edge]; }
    /// Whichever of the two faces comes first in the list is measured from.
    bool is_first(std::size_t face, std::uint32_t edge) const {
        return begin_ + face < edges_[begin_ + face].across[edge] >> 2;
    }
    OppositeVertex opposite_vertex(const Question& edge) const;

    MeshFaces faces_;
    std::span<FaceEdges> edges_;
    std::span<const EdgeSlope> crowded_;
    float open_;

    std::size_t begin_ = 0;
    std::size_t size_ = 0;
    UninitializedVector<TriangleFrame> frames_;  // of the stretch, then of the faces beyond its borders
    std::vector<FaceSlopes> slopes_;
    std::vector<std::uint32_t> across_;  // by face and edge, places in frames_; of edges without a pair, of the face
    std::vector<Triangle> beyond_;       // the faces beyond the borders, once for each edge there
    WedgeBatch wedges_;
    std::vector<Question> questions_;
    PlaneSides sides_;
};

/// Calls f(stretch) for stretches that cover the faces, on all cores. The stretches are the same on any number of them.
template <typename Function>
void measure_edges(const MeshFaces& faces, std::span<FaceEdges> edges, std::span<const EdgeSlope> crowded, float open,
                   const Function& f) {
    tbb::enumerable_thread_specific<EdgeSlopes> stretches([&] { return EdgeSlopes(faces, edges, crowded, open); });
    for_each_stretch(faces.triangles.size(), OrderedFaces::stretch,
                     [&](std::size_t, std::size_t begin, std::size_t end) {
                         EdgeSlopes& stretch = stretches.local();
                         stretch.measure(begin, end);
                         f(stretch);
                     });
}

/// Where the corner opposite the base is obtuse, its two planes lean outward so that each contains what the other
/// contains: the obtuse corner's vertices are cut off otherwise. No other corner of a triangle is obtuse.
void lean(const TriangleFrame& frame, FaceSlopes& slopes);

}  // namespace clsdf::polyhedra

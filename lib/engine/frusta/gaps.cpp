#include "frusta/gaps.hpp"

#include "core/parallel.hpp"
#include "frusta/one_lane.hpp"
#include "topology/topology.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace clsdf::engine {

namespace {

/// Marks of the edges at a vertex.
class EdgesAround {
public:
    /// The two edges of a face.
    void add(const MeasuredFaces& faces, const Corner& corner) {
        const MeasuredFace& face = faces[corner.face];
        marks_ |= face.marks[corner.vertex];
        marks_ |= face.marks[previous_of_three(corner.vertex)];
    }

    bool has(std::uint8_t mark) const { return (marks_ & mark) != 0; }
    bool are_mixed() const { return has(edge_convex) && has(edge_concave); }
    bool can_be_mixed() const { return are_mixed() || has(edge_unoriented); }

private:
    std::uint8_t marks_ = 0;
};

/// Decides one vertex after the other; keeps its memory in between.
class GapTest {
public:
    GapTest(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
            const MeasuredFaces& measured)
        : faces_(faces), edges_(edges), rings_(rings), measured_(measured), per_unit_(gap_scale(faces.lattice)) {}

    /// VertexMark of a vertex.
    std::uint8_t marks_of(std::uint32_t vertex) {
        EdgesAround edges;
        for (std::size_t i = 0; i < rings_.size(vertex); ++i) edges.add(measured_, rings_.corner(vertex, i));
        return static_cast<std::uint8_t>((edges.are_mixed() ? vertex_saddle : 0) |
                                         (has_gap(vertex, edges) ? vertex_gap : 0));
    }

private:
    /// Only a closed fan with edges of both kinds can leave directions out, and only if every fan of the vertex does.
    /// If more than two faces share an edge, there are no fans, and any normal may be left out.
    bool has_gap(std::uint32_t vertex, const EdgesAround& edges) {
        if (edges.has(edge_at_box)) return false;  // the box holds all points that are nearest to the vertex
        if (edges.has(edge_non_manifold)) return has_normals(vertex);
        if (edges.has(edge_open) || !edges.can_be_mixed()) return false;
        return fans_leave_directions_out(vertex);
    }

    bool fans_leave_directions_out(std::size_t vertex) {
        fans_.build(faces_.triangles, edges_, rings_, vertex);
        starts_.clear();
        for (std::size_t fan = 0; fan < fans_.fan_count(); ++fan) {
            EdgesAround fan_edges;
            for (std::size_t i = fans_.start(fan); i < fans_.start(fan + 1); ++i)
                fan_edges.add(measured_, fans_.faces()[i].corner);
            if (!fan_edges.can_be_mixed()) return false;
            starts_.push_back(static_cast<std::uint32_t>(fans_.start(fan)));
        }
        starts_.push_back(static_cast<std::uint32_t>(fans_.faces().size()));
        spokes_.clear();
        planes_.clear();
        for (const VertexFans::Face& face : fans_.faces()) {
            spokes_.push_back(spoke(vertex, face.neighbour));
            planes_.push_back(planes_of(face));
        }
        return leaves_directions_out(vertex);
    }

    bool has_normals(std::size_t vertex) {
        starts_.assign(1, 0);
        spokes_.clear();
        planes_.clear();
        for (std::size_t i = 0; i < rings_.size(vertex); ++i) {
            const Corner corner = rings_.corner(vertex, i);
            const Triangle& triangle = faces_.triangles[corner.face];
            spokes_.push_back(spoke(vertex, triangle[next_of_three(corner.vertex)]));
            spokes_.push_back(spoke(vertex, triangle[previous_of_three(corner.vertex)]));
        }
        return leaves_directions_out(vertex);
    }

    /// The direction from the vertex to a neighbour.
    one_lane::Vectors spoke(std::size_t vertex, std::uint32_t neighbour) const {
        return direction_to(vectors_of(to_vector(faces_.position(static_cast<std::uint32_t>(vertex)))),
                            vectors_of(to_vector(faces_.position(neighbour))), per_unit_);
    }

    one_lane::FacePlanes planes_of(const VertexFans::Face& face) const {
        const MeasuredFace& measured = measured_[face.corner.face];
        const std::uint32_t leaving = face.corner.vertex, arriving = previous_of_three(leaving);
        one_lane::FacePlanes planes;
        planes.normal = vectors_of(measured.frame.normal);
        // In the face's own order the edge that leaves the vertex comes first.
        const std::array<std::uint32_t, 2> edges{face.forward ? leaving : arriving, face.forward ? arriving : leaving};
        for (std::size_t i = 0; i < 2; ++i) {
            planes.inward[i] = vectors_of(measured.frame.inwards[edges[i]]);
            planes.above[i] = static_cast<double>(measured.slopes.above[edges[i]]);
            planes.below[i] = static_cast<double>(measured.slopes.below[edges[i]]);
        }
        return planes;
    }

    bool leaves_directions_out(std::size_t vertex) {
        order_.resize(spokes_.size());
        conditions_.resize(spokes_.size() + GAP_CONDITIONS * planes_.size());
        one_lane::GapVertex gap{};
        gap.fans = static_cast<std::uint32_t>(starts_.size() - 1);
        gap.starts = starts_.data();
        gap.faces = planes_.data();
        gap.spoke_count = static_cast<std::uint32_t>(spokes_.size());
        gap.spokes = spokes_.data();
        gap.normal = vectors_of(measured_[rings_.corner(vertex, 0).face].frame.normal);
        gap.order = order_.data();
        gap.search.conditions = conditions_.data();
        return one_lane::leaves_directions_out(&gap);
    }

    const MeshFaces& faces_;
    std::span<const FaceEdges> edges_;
    const OneRings& rings_;
    const MeasuredFaces& measured_;
    double per_unit_;  // only the directions of what it scales are used

    VertexFans fans_;
    std::vector<std::uint32_t> starts_;         // of the fans; without fans 0
    std::vector<one_lane::Vectors> spokes_;     // to the neighbours; of face i of the fans, that at its edge before
    std::vector<one_lane::FacePlanes> planes_;  // of the faces of the fans
    std::vector<std::uint32_t> order_;
    std::vector<one_lane::Vectors> conditions_;
};

}  // namespace

double gap_scale(const LatticeView& lattice) {
    return std::min(1 / lattice.unit, std::numeric_limits<double>::max());
}

std::vector<std::uint8_t> find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
                                    const MeasuredFaces& measured, std::span<const std::uint32_t> vertices) {
    std::vector<std::uint8_t> marks(vertices.size());
    tbb::enumerable_thread_specific<GapTest> tests([&] { return GapTest(faces, edges, rings, measured); });
    constexpr std::size_t grain = 8;  // kernels leave few vertices
    for_each_range(
        vertices.size(),
        [&](std::size_t begin, std::size_t end) {
            GapTest& test = tests.local();
            for (std::size_t i = begin; i < end; ++i) marks[i] = test.marks_of(vertices[i]);
        },
        grain);
    return marks;
}

}  // namespace clsdf::engine

#include "polyhedra/gaps.hpp"

#include "core/parallel.hpp"
#include "polyhedra/cone_search.hpp"
#include "polyhedra/vertex_fans.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for_each.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace clsdf::polyhedra {

void GapScreen::look_at(const EdgeSlopes& stretch) {
    const std::size_t number = stretch.begin() / OrderedFaces::stretch;
    for (std::uint32_t vertex = first_vertices_[number]; vertex < first_vertices_[number + 1]; ++vertex) {
        if (rings_.corner(vertex, rings_.size(vertex) - 1).face >= stretch.end()) {
            fans_.leave(vertex);
            continue;
        }
        const EdgesAround edges(edges_, rings_, vertex);
        marks_[vertex] = edges.vertex_mark();
        if (!edges.are_plain()) {
            fans_.leave(vertex);
        } else if (edges.are_mixed()) {
            fans_.add(stretch, vertex);
        }
    }
}

namespace {

/// Widens the normal cone, so that rounding cannot close one that has no thickness.
constexpr double cone_tolerance = 1e-8;

constexpr std::size_t large_fan = 32;

/// Sine of the steepest spoke to a face's plane where the faces around a vertex are taken for flat ground.
constexpr double flat = 1e-9;

/// Decides one vertex after the other; keeps its memory in between.
class GapTest {
public:
    GapTest(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings, const FramePlanes& planes,
            double margin, std::span<std::uint8_t> marks)
        : faces_(faces),
          edges_(edges),
          rings_(rings),
          planes_(planes),
          per_unit_(std::min(1 / faces.lattice.unit, std::numeric_limits<double>::max())),
          margin_(margin),
          marks_(marks),
          screen_(edges, rings, margin) {}

    /// Sets the mark of a vertex, or puts it off until others like it have come.
    void look_at(std::uint32_t vertex) {
        for (std::size_t i = 0; i < rings_.size(vertex); ++i) planes_.fetch_ahead(rings_.corner(vertex, i).face);
        const EdgesAround edges(edges_, rings_, vertex);
        marks_[vertex] = edges.vertex_mark();
        if (!edges.are_plain()) {
            set(vertex, has_gap(vertex, edges));
        } else if (edges.are_mixed()) {
            screen_.add(planes_, vertex);
        }
    }

    /// Sets the marks that are still put off.
    void finish() {
        for (const std::uint32_t vertex : screen_.finish()) set(vertex, fans_leave_directions_out(vertex));
    }

private:
    void set(std::uint32_t vertex, bool gap) {
        if (gap) marks_[vertex] |= vertex_gap;
    }

    static bool can_be_mixed(const EdgesAround& edges) { return edges.are_mixed() || edges.has(edge_unoriented); }

    /// Only a closed fan with edges of both kinds can leave directions out, and only if every fan of the vertex does.
    /// Where more than two faces share an edge there are no fans, and any normal may be left out.
    bool has_gap(std::uint32_t vertex, const EdgesAround& edges) {
        if (edges.has(edge_at_box)) return false;  // the box holds all points that are nearest to the vertex
        if (edges.has(edge_non_manifold)) return has_normals(vertex);
        if (edges.has(edge_open) || !can_be_mixed(edges)) return false;
        return fans_leave_directions_out(vertex);
    }

    bool fans_leave_directions_out(std::size_t vertex) {
        fans_.build(faces_.triangles, edges_, rings_, vertex);
        for (std::size_t fan = 0; fan < fans_.fan_count(); ++fan) {
            EdgesAround fan_edges;
            for (std::size_t i = fans_.start(fan); i < fans_.start(fan + 1); ++i)
                fan_edges.add(edges_, fans_.faces()[i].corner);
            if (!can_be_mixed(fan_edges)) return false;
        }
        spokes_.clear();
        for (const VertexFans::Face& face : fans_.faces()) spokes_.push_back(spoke(vertex, face.neighbour));
        return for_axes(vertex, [&](const Vector& axis) { return leaves_direction_out(axis); });
    }

    bool has_normals(std::size_t vertex) {
        spokes_.clear();
        for (std::size_t i = 0; i < rings_.size(vertex); ++i) {
            const Corner corner = rings_.corner(vertex, i);
            const Triangle& triangle = faces_.triangles[corner.face];
            spokes_.push_back(spoke(vertex, triangle[next_of_three(corner.vertex)]));
            spokes_.push_back(spoke(vertex, triangle[previous_of_three(corner.vertex)]));
        }
        return for_axes(vertex, [&](const Vector& axis) { return add_normal_cone(axis); });
    }

    /// The direction from the vertex to a neighbour.
    Vector spoke(std::size_t vertex, std::uint32_t neighbour) const {
        const Vec3& from = faces_.position(static_cast<std::uint32_t>(vertex));
        const Vec3& to = faces_.position(neighbour);
        const Vector edge = Vector(to[0] - from[0], to[1] - from[1], to[2] - from[2]) * per_unit_;
        return edge * (1 / edge.norm());
    }

    /// Whether `search` succeeds from one of several axes: unit vectors such that every normal u of the vertex, with
    /// u . spoke <= 0 for all spokes, has axis . u >= 0 for one of them. The sum of the spokes, reversed, is such an
    /// axis. Where it vanishes, or all normals are nearly perpendicular to it, as on flat ground, a face's normal and
    /// its opposite are.
    template <typename Search>
    bool for_axes(std::size_t vertex, const Search& search) {
        const Vector normal = planes_.normal(rings_.corner(vertex, 0).face);
        Vector sum = Vector::Zero();
        double height = 0;
        for (const Vector& s : spokes_) {
            sum -= s;
            height = std::max(height, std::abs(s.dot(normal)));
        }
        const double length = sum.norm();
        if (height > flat && length > 1e-6 * static_cast<double>(spokes_.size())) {
            undecided_ = false;
            const bool found = search(sum / length);
            if (!found || !undecided_) return found;
        }
        return search(normal) || search(-normal);
    }

    /// u . spoke <= 0 for all spokes.
    bool add_normal_cone(const Vector& axis) {
        search_.start(axis);
        order(0, spokes_.size());
        for (const std::size_t i : order_)
            if (!search_.add(cone_tolerance * axis - spokes_[i])) return false;
        undecided_ = undecided_ || search_.is_undecided();
        return true;
    }

    /// Every edge of a fan rejects a direction for one of its two faces at most, so where all faces reject one, all do
    /// at their edge with the face before, or all at their edge with the face after.
    bool leaves_direction_out(const Vector& axis) {
        if (!add_normal_cone(axis)) return false;
        const ConeSearch::State normals = search_.state();
        for (std::size_t fan = 0; fan < fans_.fan_count(); ++fan) {
            bool rejected = false;
            for (const bool by_edge_before : {true, false}) {
                if (rejected) break;
                search_.return_to(normals);
                collect_face_edges(fan, by_edge_before);
                rejected = add_rejections();
            }
            if (!rejected) return false;
        }
        return true;
    }

    void collect_face_edges(std::size_t fan, bool by_edge_before) {
        face_edges_.clear();
        order(fans_.start(fan), fans_.start(fan + 1));
        for (const std::size_t i : order_) {
            const VertexFans::Face& face = fans_.faces()[i];
            const bool leaving = by_edge_before == face.forward;  // in the face's own order it begins at the vertex
            const std::uint32_t k = leaving ? face.corner.vertex : previous_of_three(face.corner.vertex);
            face_edges_.push_back({face.corner.face, k});
        }
    }

    /// Whether every face rejects some unit vector u by the margin at its edge of face_edges_: g . u >= margin. The
    /// plane of an edge is the higher one of two, above the face and below, so that is a condition for each side; first
    /// that of the side on which the normals lie, which mostly decides.
    ///
    /// A linear condition can only ask for g . u >= margin (m . u) with a unit vector m, which is weaker, and least so
    /// where u is near m. Where the direction that is found does not have the margin, it becomes the next m.
    bool add_rejections() {
        constexpr int rounds = 4;  // a flat vertex has normals on both sides; more than that is left undecided
        for (int round = 0; round < rounds; ++round) {
            const Vector middle = search_.direction();
            for (const bool side_of_middle : {true, false}) {
                for (const Corner& edge : face_edges_) {
                    const bool above = (planes_.normal(edge.face).dot(middle) >= 0) == side_of_middle;
                    if (!search_.add(rejection(edge, above) - margin_ * middle)) return false;
                }
            }
            if (search_.is_undecided() || 2 * middle.dot(search_.direction()) > 1) break;
        }
        undecided_ = undecided_ || search_.is_undecided();
        return true;
    }

    /// g with g . u > 0 where the plane of the face's edge, on one side of the face, has u outside. Scaled such that g
    /// . u counts in units by which the slack widens that plane.
    Vector rejection(const Corner& edge, bool above) const {
        const LateralPlane plane = planes_.plane(edge);
        const auto slope = static_cast<double>(above ? plane.above : plane.below);
        return (plane.inward + (above ? slope : -slope) * plane.normal) * (-1 / (1 + slope));
    }

    /// Sets the order in which [first, last) are gone through: thirds of the way round, because opposite conditions
    /// contradict each other soonest. In large fans random, so that no fan can make every condition fail in turn.
    void order(std::size_t first, std::size_t last) {
        const std::size_t count = last - first;
        const std::size_t third = (count + 2) / 3;
        order_.clear();
        for (std::size_t start = 0; start < third; ++start)
            for (std::size_t i = start; i < count; i += third) order_.push_back(first + i);
        if (count <= large_fan) return;
        std::uint64_t random = 1;
        for (std::size_t i = count - 1; i > 0; --i) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            std::swap(order_[i], order_[(random >> 33) % (i + 1)]);
        }
    }

    const MeshFaces& faces_;
    std::span<const FaceEdges> edges_;
    const OneRings& rings_;
    const FramePlanes& planes_;
    double per_unit_;  // only the directions of what it scales are used
    double margin_;
    std::span<std::uint8_t> marks_;

    FanScreen screen_;
    VertexFans fans_;
    std::vector<Vector> spokes_;      // unit vectors to the neighbours; of face i of the fans, that at its edge before
    std::vector<Corner> face_edges_;  // at which the faces of a fan reject
    std::vector<std::size_t> order_;
    ConeSearch search_;
    bool undecided_ = false;  // whether a search that succeeded hangs on rounding
};

}  // namespace

void find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
               const FramePlanes& planes, double margin, std::span<const std::uint32_t> vertices,
               std::span<std::uint8_t> marks) {
    tbb::enumerable_thread_specific<GapTest> tests([&] { return GapTest(faces, edges, rings, planes, margin, marks); });
    for_each_range(vertices.size(), [&](std::size_t begin, std::size_t end) {
        GapTest& test = tests.local();
        for (const std::uint32_t vertex : vertices.subspan(begin, end - begin)) test.look_at(vertex);
    });
    tbb::parallel_for_each(tests.begin(), tests.end(), [](GapTest& test) { test.finish(); });
}

}  // namespace clsdf::polyhedra

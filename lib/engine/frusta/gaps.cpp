#include "frusta/gaps.hpp"

#include "core/parallel.hpp"
#include "frusta/topology.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clsdf::engine {

namespace {

using Vector2 = Eigen::Vector2d;

/// The directions of a circle that satisfy conditions c . u >= 0: an arc of at most half a turn, from one end
/// counter-clockwise to the other, once there is a condition. An end is kept as long as the condition that it comes
/// from, so that most cuts need neither a root nor a division.
class Arc {
public:
    enum class Answer { not_empty, empty, undecided };

    Answer cut(const Vector2& condition) {
        const double squared = condition.squaredNorm();
        if (!(squared > negligible * negligible))
            return Answer::not_empty;  // the circle is nearly that condition's own
        if (is_whole_) {
            is_whole_ = false;
            first_ = {first_direction(condition), squared};
            last_ = {-first_.direction, squared};
            return Answer::not_empty;
        }
        const double at_first = condition.dot(first_.direction);
        const double at_last = condition.dot(last_.direction);
        if (at_first >= 0 && at_last >= 0) return leaves_middle(condition);
        if (at_first < 0 && at_last < 0)
            return is_certain(at_first, squared, first_) && is_certain(at_last, squared, last_) ? Answer::empty
                                                                                                : Answer::undecided;
        if (at_first < 0) {
            first_ = {first_direction(condition), squared};
        } else {
            last_ = {first_direction(-condition), squared};
        }
        return Answer::not_empty;
    }

    Vector2 middle() const {
        if (is_whole_) return {1, 0};
        // The ends of half a turn cancel; its middle is a quarter turn after the first one.
        if (is_half_turn()) return {-first_.direction.y(), first_.direction.x()};
        return first_.direction / std::sqrt(first_.squared) + last_.direction / std::sqrt(last_.squared);
    }

private:
    /// Between the rounding of a product, 1e-15, and what decides anything about a mesh, 1e-6 (the margin of a gap).
    static constexpr double tolerance = 1e-12;
    static constexpr double negligible = 1e-14;

    struct End {
        Vector2 direction;
        double squared;  // its length's; rounding may have moved it by the tolerance
    };

    /// The first direction of the half turn that satisfies the condition.
    static Vector2 first_direction(const Vector2& condition) { return {condition.y(), -condition.x()}; }

    /// Whether a product of a condition with an end is not 0 by rounding: the tolerance times the sum of their lengths.
    static bool is_certain(double product, double squared, const End& end) {
        return product * product > 2 * tolerance * tolerance * (squared + end.squared);
    }

    bool is_half_turn() const {
        const double product = first_.direction.dot(last_.direction);
        return product < 0 && product * product > (1 - 2e-12) * first_.squared * last_.squared;
    }

    /// Both ends meet the condition, so all of the arc does. An arc of half a turn on the other side is the exception:
    /// rounding decides whether its ends are left.
    Answer leaves_middle(const Vector2& condition) const {
        return is_half_turn() && condition.dot(middle()) < 0 ? Answer::undecided : Answer::not_empty;
    }

    bool is_whole_ = true;
    End first_{Vector2::Zero(), 0};
    End last_{Vector2::Zero(), 0};
};

}  // namespace

bool ConeSearch::move_to_circle_of_last() {
    // x and y are perpendicular to the last condition, about equally long, and not short; no more is needed.
    const Vector& pole = conditions_.back();
    Vector x = direction_ - direction_.dot(pole) / pole.squaredNorm() * pole;
    if (x.squaredNorm() < 0.01) x = any_perpendicular(pole.normalized());
    const Vector y = pole.cross(x);
    Arc arc;
    for (std::size_t i = 0; i + 1 < conditions_.size(); ++i) {
        const Arc::Answer answer = arc.cut({conditions_[i].dot(x), conditions_[i].dot(y)});
        if (answer == Arc::Answer::empty) return false;
        // The arc then stays as it is, too large rather than too small: what follows may still prove it empty.
        if (answer == Arc::Answer::undecided) undecided_ = true;
    }
    if (undecided_) return true;
    const Vector2 middle = arc.middle();
    direction_ = (middle.x() * x + middle.y() * y).normalized();
    return true;
}

namespace {

/// Widens the normal cone, so that rounding cannot close one that has no thickness.
constexpr double cone_tolerance = 1e-8;

constexpr std::size_t large_fan = 32;

/// Sine of the steepest spoke to a face's plane if the faces around a vertex are taken for flat ground.
constexpr double flat = 1e-9;

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
        : faces_(faces),
          edges_(edges),
          rings_(rings),
          measured_(measured),
          per_unit_(std::min(1 / faces.lattice.unit, std::numeric_limits<double>::max())) {}

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
        for (std::size_t fan = 0; fan < fans_.fan_count(); ++fan) {
            EdgesAround fan_edges;
            for (std::size_t i = fans_.start(fan); i < fans_.start(fan + 1); ++i)
                fan_edges.add(measured_, fans_.faces()[i].corner);
            if (!fan_edges.can_be_mixed()) return false;
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
    /// axis. If it vanishes, or all normals are nearly perpendicular to it, as on flat ground, a face's normal and
    /// its opposite are.
    template <typename Search>
    bool for_axes(std::size_t vertex, const Search& search) {
        const Vector normal = measured_[rings_.corner(vertex, 0).face].frame.normal;
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

    /// Every edge of a fan rejects a direction for one of its two faces at most, so if all faces reject one, all do
    /// at their edge with the face before, or all at their edge with the face after.
    bool leaves_direction_out(const Vector& axis) {
        if (!add_normal_cone(axis)) return false;
        const ConeSearch::State normals = search_.state();
        for (std::size_t fan = 0; fan < fans_.fan_count(); ++fan) {
            bool rejected = false;
            for (const bool by_edge_before : {true, false}) {
                if (rejected) break;
                search_.return_to(normals);
                collect_face_planes(fan, by_edge_before);
                rejected = add_rejections();
            }
            if (!rejected) return false;
        }
        return true;
    }

    void collect_face_planes(std::size_t fan, bool by_edge_before) {
        face_planes_.clear();
        order(fans_.start(fan), fans_.start(fan + 1));
        for (const std::size_t i : order_) {
            const VertexFans::Face& face = fans_.faces()[i];
            const bool leaving = by_edge_before == face.forward;  // in the face's own order it begins at the vertex
            const std::uint32_t k = leaving ? face.corner.vertex : previous_of_three(face.corner.vertex);
            face_planes_.push_back(measured_[face.corner.face].plane(k));
        }
    }

    /// Whether every face rejects some unit vector u by the margin at its edge of face_planes_: g . u >= margin. The
    /// plane of an edge is the higher one of two, above the face and below, so that is a condition for each side; first
    /// that of the side on which the normals lie, which mostly decides.
    ///
    /// A linear condition can only ask for g . u >= margin (m . u) with a unit vector m, which is weaker, and least so
    /// where u is near m. If the direction that is found does not have the margin, it becomes the next m.
    bool add_rejections() {
        constexpr int rounds = 4;  // a flat vertex has normals on both sides; more than that is left undecided
        for (int round = 0; round < rounds; ++round) {
            const Vector middle = search_.direction();
            for (const bool side_of_middle : {true, false}) {
                for (const LateralPlane& plane : face_planes_) {
                    const bool above = (plane.normal.dot(middle) >= 0) == side_of_middle;
                    if (!search_.add(rejection(plane, above) - rejection_margin * middle)) return false;
                }
            }
            if (search_.is_undecided() || 2 * middle.dot(search_.direction()) > 1) break;
        }
        undecided_ = undecided_ || search_.is_undecided();
        return true;
    }

    /// g with g . u > 0 where the plane, on one side of the face, has u outside. Scaled such that g . u counts in units
    /// by which the slack widens that plane.
    static Vector rejection(const LateralPlane& plane, bool above) {
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
    const MeasuredFaces& measured_;
    double per_unit_;  // only the directions of what it scales are used

    VertexFans fans_;
    std::vector<Vector> spokes_;  // unit vectors to the neighbours; of face i of the fans, that at its edge before
    std::vector<LateralPlane> face_planes_;  // at which the faces of a fan reject
    std::vector<std::size_t> order_;
    ConeSearch search_;
    bool undecided_ = false;  // whether a search that succeeded hangs on rounding
};

}  // namespace

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

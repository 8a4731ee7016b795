#include "triangle.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::reference {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point2 = Kernel::Point_2;
using Point3 = Kernel::Point_3;

Point3 point3(const Vec3& point) {
    return {point[0], point[1], point[2]};
}

/// Without the coordinate `axis`; the others keep their cyclic order.
Point2 project(const Vec3& point, std::size_t axis) {
    return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
}

int turn(const Point2& a, const Point2& b, const Point2& c) {
    return static_cast<int>(CGAL::orientation(a, b, c));
}

int side_of_plane(const Corners& triangle, const Vec3& point) {
    return static_cast<int>(
        CGAL::orientation(point3(triangle[0]), point3(triangle[1]), point3(triangle[2]), point3(point)));
}

/// The sign of turn(from, to, point) once a point on the line through `from` and `to` is moved by (+e, +e^2).
int moved_turn(int sign, const Point2& from, const Point2& to) {
    if (sign != 0) {
        return sign;
    }
    if (from.y() != to.y()) {
        return to.y() < from.y() ? 1 : -1;
    }
    return to.x() > from.x() ? 1 : (to.x() < from.x() ? -1 : 0);
}

bool between(double value, double one, double other) {
    return std::min(one, other) <= value && value <= std::max(one, other);
}

bool lies_on_segment(const Vec3& from, const Vec3& to, const Vec3& point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!between(point[axis], from[axis], to[axis])) {
            return false;
        }
    }
    return CGAL::collinear(point3(from), point3(to), point3(point));
}

}  // namespace

LineMeeting meet_line(const Corners& triangle, double y, double z) {
    const Point2 line(y, z);
    const Point2 corners[3] = {project(triangle[0], 0), project(triangle[1], 0), project(triangle[2], 0)};
    LineMeeting meeting;
    meeting.facing = turn(corners[0], corners[1], corners[2]);
    bool crosses = meeting.facing != 0;
    meeting.touches = true;
    for (std::size_t i = 0; i < 3; ++i) {
        const Point2& from = corners[i];
        const Point2& to = corners[(i + 1) % 3];
        const int sign = turn(from, to, line);
        if (meeting.facing == 0 ? sign != 0 : sign == -meeting.facing) {
            return {0, false, meeting.facing};
        }
        crosses = crosses && moved_turn(sign, from, to) == meeting.facing;
    }
    meeting.crossing = crosses ? meeting.facing : 0;
    return meeting;
}

int side_along_x(const Corners& triangle, int facing, const Vec3& point) {
    return side_of_plane(triangle, point) * facing;
}

bool lies_on(const Corners& triangle, const Vec3& point) {
    if (side_of_plane(triangle, point) != 0) {
        return false;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Point2 corners[3] = {project(triangle[0], axis), project(triangle[1], axis), project(triangle[2], axis)};
        const int facing = turn(corners[0], corners[1], corners[2]);
        if (facing == 0) {
            continue;
        }
        const Point2 projected = project(point, axis);
        return std::ranges::all_of(std::array{0, 1, 2}, [&](int i) {
            const auto k = static_cast<std::size_t>(i);
            return turn(corners[k], corners[(k + 1) % 3], projected) != -facing;
        });
    }
    // Collinear: two of the edges cover the third.
    return lies_on_segment(triangle[0], triangle[1], point) || lies_on_segment(triangle[1], triangle[2], point);
}

namespace {

using Wide = long double;
using WideVector = Eigen::Matrix<Wide, 3, 1>;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Below this ratio of height to longest edge, double precision cannot distinguish a triangle from its edges.
constexpr Wide degenerate_ratio = 4 * Wide(std::numeric_limits<double>::epsilon());

WideVector difference(const Vec3& to, const Vec3& from) {
    return {Wide(to[0]) - Wide(from[0]), Wide(to[1]) - Wide(from[1]), Wide(to[2]) - Wide(from[2])};
}

/// The norm without overflow or underflow of the squares.
template <typename Scalar>
Scalar stable_norm(const Eigen::Matrix<Scalar, 3, 1>& vector) {
    const Scalar largest = vector.cwiseAbs().maxCoeff();
    if (largest > Scalar(1e-140) && largest < Scalar(1e140)) {
        return std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    }
    if (largest == 0 || !std::isfinite(largest)) {
        return largest;
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    const Eigen::Matrix<Scalar, 3, 1> scaled =
        vector.unaryExpr([exponent](Scalar component) { return std::ldexp(component, -exponent); });
    return std::ldexp(scaled.norm(), exponent);
}

Vec3 translated(const Vec3& point, const Eigen::Vector3d& by) {
    return {point[0] + by[0], point[1] + by[1], point[2] + by[2]};
}

Site edge_site(std::size_t one, std::size_t other) {
    const std::size_t sum = one + other;  // edge k runs from vertex k to vertex k + 1
    return sum == 1 ? Site::edge0 : sum == 3 ? Site::edge1 : Site::edge2;
}

bool is_better(double distance, Site site, const TriangleFrame::Closest& best) {
    return distance < best.distance || (distance == best.distance && site < best.site);
}

}  // namespace

TriangleFrame::TriangleFrame(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 given[3] = {a, b, c};
    std::size_t order[3] = {0, 1, 2};
    std::stable_sort(order, order + 3, [&](std::size_t left, std::size_t right) { return given[left] < given[right]; });
    for (std::size_t i = 0; i < 3; ++i) {
        vertices_[i] = given[order[i]];
        vertex_sites_[i] = static_cast<Site>(order[i]);
    }

    constexpr unsigned char ends[3][2] = {{0, 1}, {1, 2}, {0, 2}};
    WideVector directions[3];
    Wide lengths[3];
    for (std::size_t i = 0; i < 3; ++i) {
        const auto [from, to] = ends[i];
        const WideVector along = difference(vertices_[to], vertices_[from]);
        lengths[i] = stable_norm(along);
        directions[i] = lengths[i] > 0 ? WideVector(along / lengths[i]) : WideVector(WideVector::Zero());
        edges_[i] = {from, to, edge_site(order[from], order[to]), directions[i].cast<double>()};
    }

    // The altitude over the longest edge, then the cross product with that edge. So the normal is perpendicular to the
    // edge to the last bit, also for thin triangles. The remaining error turns the frame about that edge.
    const auto longest = static_cast<std::size_t>(std::max_element(lengths, lengths + 3) - lengths);
    const std::size_t opposite = 3U - ends[longest][0] - ends[longest][1];
    WideVector altitude = difference(vertices_[opposite], vertices_[ends[longest][0]]);
    altitude -= altitude.dot(directions[longest]) * directions[longest];
    const Wide height = stable_norm(altitude);
    degenerate_ = !(height > degenerate_ratio * lengths[longest]);
    normal_.setZero();
    for (Eigen::Vector3d& outward : outward_) {
        outward.setZero();
    }
    if (degenerate_) {
        return;
    }
    const WideVector normal = directions[longest].cross(altitude / height).normalized();
    normal_ = normal.cast<double>();
    for (std::size_t i = 0; i < 3; ++i) {
        WideVector outward = directions[i].cross(normal).normalized();
        const std::size_t inner = 3U - ends[i][0] - ends[i][1];
        if (outward.dot(difference(vertices_[inner], vertices_[ends[i][0]])) > 0) {
            outward = -outward;
        }
        outward_[i] = outward.cast<double>();
    }
}

Eigen::Vector3d TriangleFrame::offset(const ExactPosition& query, std::size_t vertex) const {
    const Vec3& v = vertices_[vertex];
    return {(query.head[0] - v[0]) + query.tail[0], (query.head[1] - v[1]) + query.tail[1],
            (query.head[2] - v[2]) + query.tail[2]};
}

double TriangleFrame::height_bound(const ExactPosition& query) const {
    const Eigen::Vector3d from = offset(query, 0);
    return std::fabs(normal_.dot(from)) - 4 * epsilon * from.lpNorm<1>();
}

void TriangleFrame::consider_vertex(const Eigen::Vector3d* offsets, std::size_t vertex, Closest& best) const {
    const double distance = stable_norm(offsets[vertex]);
    if (is_better(distance, vertex_sites_[vertex], best)) {
        best = {distance, vertex_sites_[vertex], vertices_[vertex]};
    }
}

void TriangleFrame::consider_edge(const Eigen::Vector3d* offsets, const Edge& edge, Closest& best) const {
    const double along = edge.direction.dot(offsets[edge.from]);
    const double beyond = edge.direction.dot(offsets[edge.to]);  // negative before the edge's end
    const bool at_start = along <= 4 * epsilon * offsets[edge.from].lpNorm<1>();
    const bool at_end = beyond >= -4 * epsilon * offsets[edge.to].lpNorm<1>();
    if (at_start) {
        consider_vertex(offsets, edge.from, best);
    }
    if (at_end) {
        consider_vertex(offsets, edge.to, best);
    }
    if (at_start || at_end) {
        return;
    }
    // Measured from the nearer end, because the rounding grows with the distance from it.
    const std::size_t base = along <= -beyond ? edge.from : edge.to;
    const Eigen::Vector3d foot = (along <= -beyond ? along : beyond) * edge.direction;
    const Eigen::Vector3d beside = offsets[base] - foot;
    const double distance = stable_norm(beside);
    if (is_better(distance, edge.site, best)) {
        best = {distance, edge.site, translated(vertices_[base], foot)};
    }
}

TriangleFrame::Closest TriangleFrame::closest(const ExactPosition& query) const {
    const Eigen::Vector3d offsets[3] = {offset(query, 0), offset(query, 1), offset(query, 2)};
    Closest best{std::numeric_limits<double>::infinity(), Site::face, {}};
    bool over_the_face = !degenerate_;
    for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector3d& from = offsets[edges_[i].from];
        if (degenerate_ || outward_[i].dot(from) >= -4 * epsilon * from.lpNorm<1>()) {
            over_the_face = false;
            consider_edge(offsets, edges_[i], best);
        }
    }
    if (over_the_face) {
        const double height = normal_.dot(offsets[0]);
        const Eigen::Vector3d foot = offsets[0] - height * normal_;
        best = {std::fabs(height), Site::face, translated(vertices_[0], foot)};
    }
    // A point on the triangle has the distance 0 and no rounding of it.
    const double rounding = 8 * epsilon * offsets[0].cwiseAbs().cwiseMax(offsets[1].cwiseAbs()).lpNorm<1>();
    if (best.distance <= rounding && query.rounding() == 0 &&
        lies_on({vertices_[0], vertices_[1], vertices_[2]}, query.head)) {
        best.distance = 0;
        best.point = query.head;
    }
    return best;
}

}  // namespace clsdf::reference

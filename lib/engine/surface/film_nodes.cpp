#include "surface/film_nodes.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace clsdf {

namespace {

// A piece of film has no more corners than that.
constexpr std::size_t most_corners = 12;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Half the cross product.
Vec3 area_vector(const Vec3& a, const Vec3& b) {
    return {0.5 * (a[1] * b[2] - a[2] * b[1]), 0.5 * (a[2] * b[0] - a[0] * b[2]), 0.5 * (a[0] * b[1] - a[1] * b[0])};
}

/// Adds n_j y_k, made symmetric.
void add_moment(std::array<double, 6>& moment, const Vec3& n, const Vec3& y) {
    for (std::size_t axis = 0; axis < 3; ++axis) moment[axis] += n[axis] * y[axis];
    moment[3] += 0.5 * (n[0] * y[1] + n[1] * y[0]);
    moment[4] += 0.5 * (n[0] * y[2] + n[2] * y[0]);
    moment[5] += 0.5 * (n[1] * y[2] + n[2] * y[1]);
}

void set_ball(FilmNodes::Node& node) {
    for (std::size_t axis = 0; axis < 3; ++axis) node.centre[axis] = (node.lower[axis] + node.upper[axis]) / 2;
    node.radius = length(difference(node.upper, node.centre)) * (1 + 1e-9);
}

FilmNodes::Node parent(const FilmNodes::Node& a, const FilmNodes::Node& b) {
    FilmNodes::Node node{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        node.lower[axis] = std::min(a.lower[axis], b.lower[axis]);
        node.upper[axis] = std::max(a.upper[axis], b.upper[axis]);
    }
    set_ball(node);
    for (const FilmNodes::Node* child : {&a, &b}) {
        node.area += child->area;
        for (std::size_t axis = 0; axis < 3; ++axis) node.normal[axis] += child->normal[axis];
        for (std::size_t i = 0; i < node.moment.size(); ++i) node.moment[i] += child->moment[i];
        add_moment(node.moment, child->normal, difference(child->centre, node.centre));
    }
    return node;
}

}  // namespace

FilmNodes::FilmNodes(std::span<const Vec3> positions, std::span<const std::size_t> begins) {
    std::vector<Node> leaves;
    for (std::size_t loop = 0; loop + 1 < begins.size(); ++loop) {
        std::vector<std::uint32_t> polygon(begins[loop + 1] - begins[loop]);
        std::iota(polygon.begin(), polygon.end(), static_cast<std::uint32_t>(begins[loop]));
        cut(polygon, leaves);
    }
    if (leaves.empty()) return;
    for (Node& leaf : leaves) describe(leaf, positions);
    nodes_.reserve(2 * leaves.size() - 1);
    build(leaves);
}

// The chord counts in both directions, so that the pieces together turn as the loop does.
void FilmNodes::cut(std::span<const std::uint32_t> polygon, std::vector<Node>& leaves) {
    if (polygon.size() <= most_corners) {
        Node leaf{};
        leaf.corner = static_cast<std::uint32_t>(corners_.size());
        leaf.corners = static_cast<std::uint32_t>(polygon.size());
        leaves.push_back(leaf);
        corners_.insert(corners_.end(), polygon.begin(), polygon.end());
        return;
    }
    const std::size_t half = polygon.size() / 2;
    cut(polygon.first(half + 1), leaves);
    std::vector<std::uint32_t> rest(polygon.begin() + static_cast<std::ptrdiff_t>(half), polygon.end());
    rest.push_back(polygon.front());
    cut(rest, leaves);
}

/// The film is a fan of triangles around the mean of the corners.
void FilmNodes::describe(Node& leaf, std::span<const Vec3> positions) const {
    const std::span<const std::uint32_t> corners = corners_of(leaf);
    leaf.lower.fill(infinity);
    leaf.upper.fill(-infinity);
    Vec3 apex{};
    for (const std::uint32_t corner : corners)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double x = positions[corner][axis];
            leaf.lower[axis] = std::min(leaf.lower[axis], x);
            leaf.upper[axis] = std::max(leaf.upper[axis], x);
            apex[axis] += x / static_cast<double>(corners.size());
        }
    set_ball(leaf);
    const Vec3 from_centre = difference(apex, leaf.centre);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 a = difference(positions[corners[i]], apex),
                   b = difference(positions[corners[i + 1 < corners.size() ? i + 1 : 0]], apex);
        const Vec3 normal = area_vector(a, b);
        leaf.area += length(normal);
        Vec3 middle{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            leaf.normal[axis] += normal[axis];
            middle[axis] = from_centre[axis] + (a[axis] + b[axis]) / 3;
        }
        add_moment(leaf.moment, normal, middle);
    }
}

std::uint32_t FilmNodes::build(std::span<Node> leaves) {
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    if (leaves.size() == 1) {
        nodes_.push_back(leaves.front());
        return number;
    }
    nodes_.emplace_back();
    Vec3 lower = leaves.front().centre, upper = lower;
    for (const Node& leaf : leaves)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], leaf.centre[axis]);
            upper[axis] = std::max(upper[axis], leaf.centre[axis]);
        }
    const Vec3 extent = difference(upper, lower);
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(extent) - extent.begin());
    const std::size_t half = leaves.size() / 2;
    std::ranges::nth_element(leaves, leaves.begin() + static_cast<std::ptrdiff_t>(half), {},
                             [&](const Node& leaf) { return std::pair(leaf.centre[axis], leaf.corner); });
    const std::uint32_t first = build(leaves.first(half)), second = build(leaves.subspan(half));
    nodes_[number] = parent(nodes_[first], nodes_[second]);
    nodes_[number].second = second;
    return number;
}

// With r = centre - point and d its length, the moments give 4 pi turns = (n.r + tr M) / d^3 - 3 r.Mr / d^5. What they
// leave out is at most 3 area radius^2 / gap^4, its gradient 12 area radius^2 / gap^5; the second derivative of the
// whole is at most 6 area / gap^4.
FilmNodes::Linear FilmNodes::linear(const Node& node, const Vec3& point, double ball) {
    const Vec3 r = difference(node.centre, point);
    const double distance = length(r), gap = distance - node.radius, away = gap - ball;
    if (!(away > nearest * node.radius)) return {0, {infinity, {}, infinity}};
    const double per = 1 / distance, per_3 = per * per * per, per_5 = per_3 * per * per;
    const auto& [xx, yy, zz, xy, xz, yz] = node.moment;
    const Vec3 moved{xx * r[0] + xy * r[1] + xz * r[2], xy * r[0] + yy * r[1] + yz * r[2],
                     xz * r[0] + yz * r[1] + zz * r[2]};
    const double along = dot(r, moved), level = dot(node.normal, r) + xx + yy + zz;
    Linear result{per_sphere * (level * per_3 - 3 * along * per_5), {}};
    for (std::size_t axis = 0; axis < 3; ++axis)
        result.change.gradient[axis] =
            -per_sphere * (node.normal[axis] * per_3 - (3 * level * r[axis] + 6 * moved[axis]) * per_5 +
                           15 * along * r[axis] * per_5 * per * per);
    const double per_gap = node.radius / (gap * gap);
    const double left_out = 3 * per_sphere * node.area * per_gap * per_gap;
    const double most = film_change(node.area, away, ball);
    result.change.most = most + left_out;
    result.change.beside = 1.5 * ball / away * most + left_out + 4 * left_out * ball / gap;
    return result;
}

}  // namespace clsdf

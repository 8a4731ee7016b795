#include "surface/film_tree.hpp"

#include "surface/film_bounds.hpp"
#include "surface/loop_turns.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace clsdf {

namespace {

// A piece of film has no more corners than that.
constexpr std::size_t most_corners = 12;
// The most that the moments of one node may be off by, in turns: first a rough sum, then a better one.
constexpr std::array<double, 2> tolerances{1.0 / 1024, 1.0 / 16384};
// Above the rounding of all sums.
constexpr double slack = 1e-6;
constexpr double per_sphere = 0.25 * std::numbers::inv_pi;

Vec3 difference(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

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

}  // namespace

FilmTree::FilmTree(std::shared_ptr<const OpenBoundary> boundary, double unit)
    : boundary_(std::move(boundary)), unit_(unit) {
    for (std::size_t loop = 0; loop + 1 < boundary_->begins.size(); ++loop) {
        std::vector<std::uint32_t> polygon(boundary_->begins[loop + 1] - boundary_->begins[loop]);
        std::iota(polygon.begin(), polygon.end(), static_cast<std::uint32_t>(boundary_->begins[loop]));
        cut(polygon);
    }
    if (pieces_.empty()) return;
    std::vector<Node> leaves(pieces_.size());
    for (std::size_t i = 0; i < leaves.size(); ++i) leaves[i] = leaf(static_cast<std::uint32_t>(i));
    nodes_.reserve(2 * leaves.size() - 1);
    build(leaves);
}

// The chord counts in both directions, so that the pieces together turn as the loop does.
void FilmTree::cut(std::span<const std::uint32_t> polygon) {
    if (polygon.size() <= most_corners) {
        pieces_.push_back({corners_.size(), corners_.size() + polygon.size()});
        corners_.insert(corners_.end(), polygon.begin(), polygon.end());
        return;
    }
    const std::size_t half = polygon.size() / 2;
    cut(polygon.first(half + 1));
    std::vector<std::uint32_t> rest(polygon.begin() + static_cast<std::ptrdiff_t>(half), polygon.end());
    rest.push_back(polygon.front());
    cut(rest);
}

Vec3 FilmTree::scaled(const Vec3& position) const {
    // A product with a power of two is exact, and cannot overflow where the difference of the given ones does.
    const double scale = 1 / unit_;
    return {position[0] * scale, position[1] * scale, position[2] * scale};
}

template <typename Function>
void FilmTree::for_each_edge(std::uint32_t number, const Function& f) const {
    const std::span<const std::uint32_t> piece = corners_of(number);
    const Vec3 first = scaled(boundary_->corners[piece.front()]);
    Vec3 a = first;
    for (std::size_t i = 1; i <= piece.size(); ++i) {
        const Vec3 b = i < piece.size() ? scaled(boundary_->corners[piece[i]]) : first;
        f(a, b);
        a = b;
    }
}

/// The film is a fan of triangles around the mean of the corners.
FilmTree::Node FilmTree::leaf(std::uint32_t number) const {
    const std::span<const std::uint32_t> piece = corners_of(number);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Node node{};
    node.piece = number;
    node.lower.fill(infinity);
    node.upper.fill(-infinity);
    Vec3 apex{};
    for (const std::uint32_t corner : piece) {
        const Vec3 at = scaled(boundary_->corners[corner]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            node.lower[axis] = std::min(node.lower[axis], at[axis]);
            node.upper[axis] = std::max(node.upper[axis], at[axis]);
            apex[axis] += at[axis] / static_cast<double>(piece.size());
        }
    }
    set_ball(node);
    const Vec3 from_centre = difference(apex, node.centre);
    for_each_edge(number, [&](const Vec3& from, const Vec3& to) {
        const Vec3 a = difference(from, apex), b = difference(to, apex);
        const Vec3 normal = area_vector(a, b);
        node.area += length(normal);
        Vec3 middle{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            node.normal[axis] += normal[axis];
            middle[axis] = from_centre[axis] + (a[axis] + b[axis]) / 3;
        }
        add_moment(node.moment, normal, middle);
    });
    return node;
}

void FilmTree::set_ball(Node& node) {
    for (std::size_t axis = 0; axis < 3; ++axis) node.centre[axis] = (node.lower[axis] + node.upper[axis]) / 2;
    node.radius = length(difference(node.upper, node.centre)) * (1 + 1e-9);
}

FilmTree::Node FilmTree::parent(const Node& a, const Node& b) {
    Node node{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        node.lower[axis] = std::min(a.lower[axis], b.lower[axis]);
        node.upper[axis] = std::max(a.upper[axis], b.upper[axis]);
    }
    set_ball(node);
    for (const Node* child : {&a, &b}) {
        node.area += child->area;
        for (std::size_t axis = 0; axis < 3; ++axis) node.normal[axis] += child->normal[axis];
        for (std::size_t i = 0; i < node.moment.size(); ++i) node.moment[i] += child->moment[i];
        add_moment(node.moment, child->normal, difference(child->centre, node.centre));
    }
    return node;
}

std::uint32_t FilmTree::build(std::span<Node> leaves) {
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
                             [&](const Node& leaf) { return std::pair(leaf.centre[axis], leaf.piece); });
    const std::uint32_t first = build(leaves.first(half)), second = build(leaves.subspan(half));
    nodes_[number] = parent(nodes_[first], nodes_[second]);
    nodes_[number].second = second;
    return number;
}

/// visit: whether all of a node is done.
template <typename Visit>
void FilmTree::walk(const Visit& visit) const {
    std::array<std::uint32_t, 64> open;  // more than the depth: every node halves its leaves
    std::size_t count = 0;
    if (!nodes_.empty()) open[count++] = 0;
    while (count > 0) {
        const std::uint32_t number = open[--count];
        const Node& node = nodes_[number];
        if (!visit(node) && node.second != 0) {
            open[count++] = node.second;
            open[count++] = number + 1;
        }
    }
}

FilmTree::Sum FilmTree::sum(const Vec3& point, double tolerance) const {
    const Vec3 at = scaled(point);
    Sum sum;
    walk([&](const Node& node) {
        const Vec3 r = difference(node.centre, at);
        const double distance = length(r), gap = distance - node.radius;
        // The ray towards -x may meet the film: then its turns are not its solid angle.
        const bool may_meet = at[1] >= node.lower[1] && at[1] <= node.upper[1] && at[2] >= node.lower[2] &&
                              at[2] <= node.upper[2] && at[0] >= node.lower[0];
        const double per_gap = node.radius / (gap * gap);
        const double error = 3 * per_sphere * node.area * per_gap * per_gap;
        // Nearer, edges between pieces would have rounding errors of their own.
        if (gap > 0.25 * node.radius && !may_meet && error <= tolerance) {
            const double inverse = 1 / distance, square = inverse * inverse;
            const Vec3 u{r[0] * inverse, r[1] * inverse, r[2] * inverse};
            const auto& [xx, yy, zz, xy, xz, yz] = node.moment;
            const double along = xx * u[0] * u[0] + yy * u[1] * u[1] + zz * u[2] * u[2] +
                                 2 * (xy * u[0] * u[1] + xz * u[0] * u[2] + yz * u[1] * u[2]);
            sum.far += per_sphere * square * (dot(node.normal, u) + inverse * (xx + yy + zz - 3 * along));
            sum.error += error;
            return true;
        }
        if (node.second == 0) {
            const std::span<const std::uint32_t> piece = corners_of(node.piece);
            sum.near = turned_by_loop(
                sum.near, piece.size(), [&](std::size_t i) -> const Vec3& { return boundary_->corners[piece[i]]; },
                point, unit_);
        }
        return false;
    });
    return sum;
}

FilmTree::View FilmTree::look_by_moments(const Vec3& point) const {
    const double tolerance = tolerances.back();
    const Sum seen = sum(point, tolerance);
    const double turns = turns_of(seen.near) + seen.far;
    const double to_half = distance_to_half(turns) - seen.error - slack;
    return to_half > 0 ? View{static_cast<int>(std::floor(turns + 0.5)), to_half} : look(point);
}

FilmTree::View FilmTree::look(const Vec3& point, double least_to_half) const {
    for (const double tolerance : tolerances) {
        const Sum seen = sum(point, tolerance);
        const double turns = turns_of(seen.near) + seen.far;
        const double to_half = distance_to_half(turns) - seen.error - slack;
        if (to_half > least_to_half) return {static_cast<int>(std::floor(turns + 0.5)), to_half};
    }
    const SolidAngle angle = angle_of(*boundary_, point, unit_);
    return {angle.rounded, distance_to_half(angle.turns) - slack};
}

double FilmTree::change_within(const Vec3& centre, double radius) const {
    const Vec3 at = scaled(centre);
    double change = 0;
    walk([&](const Node& node) {
        const double distance = length(difference(node.centre, at)), gap = distance - node.radius - radius;
        if (node.second != 0) {
            if (!(gap > 2 * node.radius)) return false;
            change += film_change(node.area, gap, radius);
            return true;
        }
        LoopChange of_piece(distance, node.radius, node.area, radius);
        for_each_edge(node.piece,
                      [&](const Vec3& a, const Vec3& b) { of_piece.add_edge(difference(a, at), difference(b, at)); });
        change += of_piece.change().most;
        return true;
    });
    return change;
}

std::size_t FilmTree::host_bytes() const {
    return corners_.size() * sizeof(corners_[0]) + pieces_.size() * sizeof(pieces_[0]) +
           nodes_.size() * sizeof(nodes_[0]);
}

}  // namespace clsdf

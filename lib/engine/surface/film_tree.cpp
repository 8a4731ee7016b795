#include "surface/film_tree.hpp"

#include "surface/film_bounds.hpp"
#include "surface/loop_turns.hpp"

#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

FilmTree::FilmTree(std::shared_ptr<const OpenBoundary> boundary, double unit)
    : boundary_(std::move(boundary)), unit_(unit) {
    std::vector<Vec3> positions;
    positions.reserve(boundary_->corners.size());
    for (const Vec3& corner : boundary_->corners) positions.push_back(scaled(corner));
    nodes_ = FilmNodes(positions, boundary_->begins);
    corners_.reserve(nodes_.corners().size());
    for (const std::uint32_t corner : nodes_.corners()) corners_.push_back(boundary_->corners[corner]);
}

Vec3 FilmTree::scaled(const Vec3& position) const {
    // A product with a power of two is exact, and cannot overflow where the difference of the given ones does.
    const double scale = 1 / unit_;
    return {position[0] * scale, position[1] * scale, position[2] * scale};
}

FilmTree::Sum FilmTree::sum(const Vec3& point, double tolerance) const {
    const Vec3 at = scaled(point);
    Sum sum;
    sum.far = nodes_.sum(
        at, tolerance,
        [&](const FilmNodes::Node& node) {
            return at[1] >= node.lower[1] && at[1] <= node.upper[1] && at[2] >= node.lower[2] &&
                   at[2] <= node.upper[2] && at[0] >= node.lower[0];
        },
        [&](const FilmNodes::Node& leaf) {
            const std::span<const Vec3> corners = std::span(corners_).subspan(leaf.corner, leaf.corners);
            sum.near = turned_by_loop(
                sum.near, corners.size(), [&](std::size_t i) -> const Vec3& { return corners[i]; }, point, unit_);
        });
    return sum;
}

FilmTree::View FilmTree::look_by_tenths(const Vec3& point) const {
    for (const double tolerance : std::span(film_tolerances).subspan(1)) {
        const Sum seen = sum(point, tolerance);
        const double turns = turns_of(seen.near) + seen.far.turns, error = seen.far.error + film_slack;
        const double to_half = distance_to_half(turns) - error;
        const bool is_one_tenth = std::floor(10 * (turns - error)) == std::floor(10 * (turns + error));
        if (tolerance == film_tolerances.back() ? is_one_tenth || to_half > 0 : is_one_tenth)
            return {static_cast<int>(std::floor(turns + 0.5)), to_half};
    }
    return look_at_all(point);
}

FilmTree::View FilmTree::look(const Vec3& point, double least_to_half) const {
    for (const double tolerance : film_tolerances) {
        const Sum seen = sum(point, tolerance);
        const double turns = turns_of(seen.near) + seen.far.turns;
        const double to_half = distance_to_half(turns) - seen.far.error - film_slack;
        if (to_half > least_to_half) return {static_cast<int>(std::floor(turns + 0.5)), to_half};
    }
    return look_at_all(point);
}

FilmTree::View FilmTree::look_at_all(const Vec3& point) const {
    const SolidAngle angle = angle_of(*boundary_, point, unit_);
    return {angle.rounded, distance_to_half(angle.turns) - film_slack};
}

double FilmTree::change_within(const Vec3& centre, double radius) const {
    const Vec3 at = scaled(centre);
    double change = 0;
    nodes_.walk([&](const FilmNodes::Node& node) {
        const double distance = length(difference(node.centre, at)), gap = distance - node.radius - radius;
        if (!node.is_leaf()) {
            if (!(gap > 2 * node.radius)) return false;
            change += film_change(node.area, gap, radius);
            return true;
        }
        LoopChange of_piece(distance, node.radius, node.area, radius);
        const std::span<const Vec3> corners = std::span(corners_).subspan(node.corner, node.corners);
        const Vec3 first = difference(scaled(corners.front()), at);
        Vec3 a = first;
        for (std::size_t i = 1; i <= corners.size(); ++i) {
            const Vec3 b = i < corners.size() ? difference(scaled(corners[i]), at) : first;
            of_piece.add_edge(a, b);
            a = b;
        }
        change += of_piece.change().most;
        return true;
    });
    return change;
}

}  // namespace clsdf

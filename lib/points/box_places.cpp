#include "points/box_places.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "points/curve_order.hpp"
#include "points/signs_by_host.hpp"
#include "surface/film_bounds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace clsdf::points {

namespace {

constexpr std::size_t width = CLSDF_TREE_WIDTH;
// Above the rounding of floats in a sum of three squares.
constexpr double rounding = 1e-6;

using Squares = std::array<float, width>;

/// Squared distances between a box and the boxes of a node's children.
Squares squared_distances(const PointNode& node, const engine::UnitBox& box) {
    Squares squares{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < width; ++i) {
            const float below = node.lower[axis][i] - box.upper[axis], above = box.lower[axis] - node.upper[axis][i];
            const float apart = std::max(std::max(below, above), 0.0F);
            squares[i] += apart * apart;
        }
    return squares;
}

/// The same, in the mesh's units, of a box and the smallest one around a triangle. A result above `most` may be less
/// than the true one.
double squared_distance(const std::array<Vec3, 3>& corners, const Box& box, double most) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3 && squared <= most; ++axis) {
        const double a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
        const double above = std::min(std::min(a, b), c) - box.upper[axis];
        const double below = box.lower[axis] - std::max(std::max(a, b), c);
        const double apart = std::max(std::max(above, below), 0.0);
        squared += apart * apart;
    }
    return squared;
}

/// A half width as its square, made larger by more than the rounding of what is compared with it.
struct Reach {
    double squared;
    float squared_in_units;
    double least_squared_in_units;  ///< smaller by as much

    Reach(double half_width, double unit)
        : squared(half_width * half_width * (1 + 1e-14)),
          squared_in_units(static_cast<float>(std::min(half_width / unit * (half_width / unit) * (1 + 4 * rounding),
                                                       static_cast<double>(std::numeric_limits<float>::max())))),
          least_squared_in_units(half_width / unit * (half_width / unit) * (1 - 4 * rounding)) {}
};

Squares all_infinite() {
    Squares squares;
    squares.fill(std::numeric_limits<float>::infinity());
    return squares;
}

/// The search for triangles near a box.
class Search {
public:
    Search(const engine::SearchedMesh& searched, const Box& box, const Reach& reach)
        : mesh_(searched.mesh), tree_(searched.tree), box_(box), unit_box_(box, mesh_.lattice), reach_(reach) {}

    bool finds_face() {
        return engine::traverse(
            tree_, [&](const PointNode& node, std::uint32_t level) { return near_children(node, level); },
            [&](std::uint32_t bits, std::uint32_t level) { return next_child(bits, level); },
            [&](std::size_t face) { return is_near(face); });
    }

    /// If none is: a lower bound of the square of the distance of all of them, in units.
    double lower_bound() const { return static_cast<double>(std::ranges::min(bounds_)) * (1 - rounding); }

private:
    std::uint32_t near_children(const PointNode& node, std::uint32_t level) {
        const Squares squares = squared_distances(node, unit_box_);
        constexpr float infinity = std::numeric_limits<float>::infinity();
        const float most = reach_.squared_in_units;
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < width; ++i) {
            bits |= squares[i] <= most ? 1U << i : 0U;
            bounds_[i] = std::min(bounds_[i], squares[i] <= most ? infinity : squares[i]);
        }
        if ((bits & (bits - 1)) != 0)
            nearest_[level] = static_cast<std::uint32_t>(std::ranges::min_element(squares) - squares.begin());
        return bits;
    }

    /// The nearest child, which is the likeliest to have a near face, comes first.
    std::uint32_t next_child(std::uint32_t bits, std::uint32_t level) const {
        const std::uint32_t nearest = nearest_[level];
        return (bits >> nearest & 1U) != 0 ? nearest : static_cast<std::uint32_t>(std::countr_zero(bits));
    }

    bool is_near(std::size_t face) {
        const double squared = squared_distance(mesh_.corners(face), box_, reach_.squared);
        if (squared <= reach_.squared) return true;
        const double per_unit = 1 / mesh_.lattice.unit;
        bounds_[0] = std::min(bounds_[0], static_cast<float>(squared * per_unit * per_unit));
        return false;
    }

    const engine::PointMesh& mesh_;
    const engine::WideTree& tree_;
    const Box& box_;
    engine::UnitBox unit_box_;
    const Reach& reach_;
    Squares bounds_ = all_infinite();
    std::array<std::uint32_t, CLSDF_TREE_LEVELS + 1> nearest_{};  // child of the present node of each level
};

Vec3 centre_of(const Box& box) {
    Vec3 centre;
    for (std::size_t axis = 0; axis < 3; ++axis)
        centre[axis] =
            std::clamp(box.lower[axis] + (box.upper[axis] / 2 - box.lower[axis] / 2), box.lower[axis], box.upper[axis]);
    return centre;
}

}  // namespace

void check_box(const Box& box, const std::string& name) {
    const auto& [lower, upper] = box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool is_finite = std::isfinite(lower[axis]) && std::isfinite(upper[axis]);
        if (is_finite && lower[axis] <= upper[axis]) continue;
        refuse("{} from ({}, {}, {}) to ({}, {}, {}) {}", name, lower[0], lower[1], lower[2], upper[0], upper[1],
               upper[2],
               is_finite ? "has its corners exchanged; give the lower one first"
                         : "is not finite; clip it or leave it out");
    }
}

void check_boxes(std::span<const Box> boxes) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        check_box(boxes[i], fmt::format("box {}", i));
    }
}

namespace {

/// The film may meet a box: then it has no side. Else the rounded winding number of all of it.
std::optional<int> winding_number_of(const engine::SearchedMesh& searched, const Box& box, const Vec3& centre) {
    Vec3 half{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        half[axis] =
            std::max(box.upper[axis] - centre[axis], centre[axis] - box.lower[axis]) / searched.mesh.lattice.unit;
    return rounded_winding_number(searched, centre, length(half));
}

/// Of a box that the faces do not meet, for the rule `below`: `within` if walls or the floor may meet it.
BoxPlace place_among_walls(const engine::SearchedMesh& searched, const Box& box) {
    const Walls& walls = *searched.mesh.walls;
    if (walls.may_meet(box)) return BoxPlace::within;
    if (box.upper[2] < walls.floor()) return BoxPlace::outside;
    Vec3 point = centre_of(box);
    const bool may_meet_floor = box.lower[2] < walls.floor();
    if (may_meet_floor) point[2] = walls.floor();  // it counts as above the floor
    if (!is_inside_walls(searched, point)) return BoxPlace::outside;
    return may_meet_floor ? BoxPlace::within : BoxPlace::inside;
}

}  // namespace

void find_places(const engine::SearchedMesh& searched, SignRule rule, std::span<const Box> boxes, double half_width,
                 std::span<BoxPlace> places) {
    if (std::isinf(half_width)) {
        std::ranges::fill(places, BoxPlace::within);
        return;
    }
    const engine::PointMesh& mesh = searched.mesh;
    const Reach reach(half_width, mesh.lattice.unit);
    const bool has_sign = rule != SignRule::none;
    UninitializedVector<double> bounds(boxes.size());
    for_each_index(boxes.size(), [&](std::size_t i) {
        Search search(searched, boxes[i], reach);
        places[i] = search.finds_face() ? BoxPlace::within : has_sign ? BoxPlace::outside : BoxPlace::beyond;
        bounds[i] = search.lower_bound();
        if (mesh.has_several_regions) bounds[i] = std::min(bounds[i], reach.least_squared_in_units);
    });
    if (!has_sign) return;

    if (mesh.walls) {
        for_each_index(
            boxes.size(),
            [&](std::size_t i) {
                if (places[i] != BoxPlace::within) places[i] = place_among_walls(searched, boxes[i]);
            },
            16);
        return;
    }
    if (mesh.film) {
        for_each_index(
            boxes.size(),
            [&](std::size_t i) {
                if (places[i] == BoxPlace::within) return;
                const std::optional<int> winding = winding_number_of(searched, boxes[i], centre_of(boxes[i]));
                places[i] = !winding ? BoxPlace::within : *winding != 0 ? BoxPlace::inside : BoxPlace::outside;
            },
            16);
        return;
    }

    // A box that the surface does not meet lies on the side of its centre.
    std::vector<std::uint32_t> open;
    std::vector<Vec3> centres;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (places[i] == BoxPlace::within) continue;
        const Vec3 centre = centre_of(boxes[i]);
        if (!engine::contains(mesh.box, centre)) continue;
        open.push_back(static_cast<std::uint32_t>(i));
        centres.push_back(centre);
    }
    const UninitializedVector<std::uint32_t> order = curve_order(centres, mesh.box);
    UninitializedVector<double> squared(open.size());
    std::vector<std::uint8_t> signs(open.size(), CLSDF_POINT_UNDECIDED);
    for_each_index(open.size(), [&](std::size_t i) {
        const std::uint32_t number = order[i];
        // The box holds a ball around its centre, and the surface is as far from the box as its bound says.
        const double distance =
            std::sqrt(bounds[open[number]]) + std::ranges::min(boxes[open[number]].extent()) / 2 / mesh.lattice.unit;
        squared[i] = distance * distance;
    });
    find_signs(searched, rule, {centres, order, squared}, signs);
    for_each_index(open.size(), [&](std::size_t i) {
        if (signs[i] == CLSDF_POINT_INSIDE) places[open[order[i]]] = BoxPlace::inside;
    });
}

}  // namespace clsdf::points

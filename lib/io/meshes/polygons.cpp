#include "io/meshes/polygons.hpp"

#include "core/parallel.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>

namespace clsdf {

namespace {

using Position = std::array<double, 2>;
using Corners = std::vector<std::uint32_t>;

/// A box in the plane; empty at first.
struct Rectangle {
    double left = std::numeric_limits<double>::infinity(), bottom = left, right = -left, top = -left;

    void add(const Rectangle& other) {
        left = std::min(left, other.left);
        bottom = std::min(bottom, other.bottom);
        right = std::max(right, other.right);
        top = std::max(top, other.top);
    }
    bool meets(const Rectangle& other) const {
        return left <= other.right && right >= other.left && bottom <= other.top && top >= other.bottom;
    }
    friend bool operator==(const Rectangle&, const Rectangle&) = default;
};

Rectangle box_of(std::initializer_list<Position> positions) {
    Rectangle box;
    for (const auto& [x, y] : positions) box.add({x, y, x, y});
    return box;
}

/// Positions in a frame in which most of the edges' length is along an axis: the boxes of parallel edges overlap there
/// only if the edges are near each other. Quarters, so that nothing is infinite.
class EdgeFrame {
public:
    explicit EdgeFrame(std::span<const Position> positions) {
        double along = 0, across = 0, largest = 0;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const Position &a = positions[i], &b = positions[(i + 1) % positions.size()];
            double x = b[0] / 4 - a[0] / 4, y = b[1] / 4 - a[1] / 4;
            const double length = std::hypot(x, y);
            if (length > 0) {
                // Four times the edge's angle: the axes are alike.
                for (int k = 0; k < 2; ++k) {
                    const double scale = k == 0 ? length : 1;
                    const double real = x / scale, imaginary = y / scale;
                    x = real * real - imaginary * imaginary;
                    y = 2 * real * imaginary;
                }
                along += length / 0x1p40 * x;
                across += length / 0x1p40 * y;
            }
            largest = std::max(largest, std::abs(a[0]) / 4 + std::abs(a[1]) / 4);
        }
        const double angle = std::atan2(across, along) / 4;
        cos_ = std::cos(angle);
        sin_ = std::sin(angle);
        slack_ = 1e-14 * largest + std::numeric_limits<double>::min();
    }

    Position position(const Position& p) const {
        return {p[0] / 4 * cos_ + p[1] / 4 * sin_, p[1] / 4 * cos_ - p[0] / 4 * sin_};
    }
    /// Contains the edge whatever was rounded.
    Rectangle box(const Position& a, const Position& b) const {
        const auto [left, bottom, right, top] = box_of({position(a), position(b)});
        return {left - slack_, bottom - slack_, right + slack_, top + slack_};
    }

private:
    double cos_ = 1, sin_ = 0, slack_ = 0;
};

/// Whether a box lies to the right of a -> b, by more than a rounding error.
bool is_right_of(const Rectangle& box, const Position& a, const Position& b) {
    const double dx = b[0] - a[0], dy = b[1] - a[1];
    const double up = dx * ((dx > 0 ? box.top : box.bottom) - a[1]);
    const double across = dy * ((dy > 0 ? box.left : box.right) - a[0]);
    return up - across < -1e-15 * (std::abs(up) + std::abs(across)) - std::numeric_limits<double>::min();
}

/// Every second bit of 64, for a number of 32 bits.
std::uint64_t spread(std::uint64_t bits) {
    for (const auto& [shift, mask] : {std::pair(16U, 0x0000FFFF0000FFFFU),
                                      {8U, 0x00FF00FF00FF00FFU},
                                      {4U, 0x0F0F0F0F0F0F0F0FU},
                                      {2U, 0x3333333333333333U},
                                      {1U, 0x5555555555555555U}})
        bits = (bits | bits << shift) & mask;
    return bits;
}

/// The places of positions along a Morton curve.
std::vector<std::uint32_t> places_on_curve(std::span<const Position> positions) {
    Rectangle box;
    for (const Position& position : positions) box.add(box_of({position}));
    const double extent = std::max(box.right / 2 - box.left / 2, box.top / 2 - box.bottom / 2);
    const auto digits = [&](double x, double least) {
        const double share = (x / 2 - least / 2) / extent;  // NaN if all positions are equal
        return share > 0 ? spread(static_cast<std::uint64_t>(share * 0xFFFFFFFFU)) : 0;
    };
    std::vector<std::pair<std::uint64_t, std::uint32_t>> codes;
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        codes.emplace_back(digits(positions[i][0], box.left) << 1 | digits(positions[i][1], box.bottom), i);
    std::ranges::sort(codes);
    std::vector<std::uint32_t> places(positions.size());
    for (std::uint32_t place = 0; place < codes.size(); ++place) places[codes[place].second] = place;
    return places;
}

/// Boxes in a tree, four at a node, in an order in which neighbours are near each other.
class BoxTree {
public:
    explicit BoxTree(std::size_t count) {
        while (first_leaf_ < count) first_leaf_ *= 4;
        boxes_.resize(first_leaf_ + chunk_count(count, 4) * 4);
    }

    /// An empty box is met by none.
    void set(std::size_t place, const Rectangle& box) {
        std::size_t node = first_leaf_ + place;
        boxes_[node] = box;
        for (node /= 4; node > 0; node /= 4) {
            Rectangle all;
            for (std::size_t child = 4 * node; child < std::min(4 * node + 4, boxes_.size()); ++child)
                all.add(boxes_[child]);
            if (all == boxes_[node]) break;
            boxes_[node] = all;
        }
    }

    /// Whether is_found(place) holds for a box that may_meet() does not exclude. steps: those that are left; with none
    /// left the search ends, and the result has no meaning.
    template <typename MayMeet, typename IsFound>
    bool any(std::size_t& steps, const MayMeet& may_meet, const IsFound& is_found) const {
        for (std::size_t node = 1; steps > 0;) {
            --steps;
            const bool is_met = may_meet(boxes_[node]);
            if (is_met && node < first_leaf_) {
                node *= 4;
                continue;
            }
            if (is_met && is_found(node - first_leaf_)) return true;
            while (node % 4 == 3) node /= 4;
            if (node == 1) return false;
            ++node;
        }
        return false;
    }

private:
    std::size_t first_leaf_ = 1;
    std::vector<Rectangle> boxes_;  // the first is not used; node n is above 4 n to 4 n + 3
};

/// Cuts ears off a polygon whose corners run counterclockwise.
class EarCutter {
public:
    explicit EarCutter(std::vector<Position> positions)
        : at_(std::move(positions)),
          previous_(at_.size()),
          next_(at_.size()),
          is_no_ear_(at_.size(), false),
          places_(places_on_curve(at_)),
          corner_at_(at_.size()),
          corners_(at_.size()),
          frame_(at_),
          edges_(at_.size()),
          tests_(tests_per_corner * at_.size()),
          steps_(most_steps(at_.size())) {
        for (std::size_t i = 0; i < at_.size(); ++i) {
            next_[i] = (i + 1) % at_.size();
            previous_[next_[i]] = i;
            corner_at_[places_[i]] = i;
            corners_.set(places_[i], box_of({at_[i]}));
            edges_.set(i, frame_.box(at_[i], at_[next_[i]]));
        }
    }

    /// The numbers of the corners of each triangle; null if the polygon has no such triangles, or if they are not found
    /// within a number of steps in proportion to the corners.
    std::optional<std::vector<std::array<std::size_t, 3>>> triangles() {
        std::vector<std::array<std::size_t, 3>> found;
        std::size_t left = at_.size(), rejected = 0;
        Cut wanted = Cut::spikes;
        for (std::size_t corner = 1; left > 2; corner = next_[corner]) {
            const bool is_cut = wanted == Cut::spikes ? is_spike(corner)
                                : wanted == Cut::ears ? !is_no_ear_[corner] && is_ear(corner)
                                                      : turn(corner) == 0;
            if (is_cut) {
                found.push_back({previous_[corner], corner, next_[corner]});
                cut(corner);
                --left;
                rejected = 0;
                if (wanted != Cut::flat) continue;
                // It may have lain on the third side of an ear.
                is_no_ear_.assign(at_.size(), false);
                wanted = Cut::ears;
            } else if (++rejected == left) {
                if (wanted == Cut::flat || has_given_up()) return std::nullopt;
                rejected = 0;
                wanted = wanted == Cut::spikes ? Cut::ears : Cut::flat;
            } else if (wanted == Cut::ears) {
                is_no_ear_[corner] = true;
            }
        }
        return found;
    }

    /// Whether the number of steps was not enough.
    bool has_given_up() const { return tests_ == 0 || steps_ == 0; }

private:
    static constexpr std::size_t tests_per_corner = 16;
    // Of the search in the trees; exact predicates take longer than a box.
    static constexpr std::size_t steps_of_predicates = 4;
    static std::size_t most_steps(std::size_t corners) {
        return std::max(256 * corners, std::min<std::size_t>(4096 * corners, 80'000'000));
    }

    /// Spikes come first: the triangle at a spike's foot may lie outside of the polygon. A flat corner is cut only if
    /// no corner is an ear.
    enum class Cut { spikes, ears, flat };

    int turn(std::size_t corner) const { return orientation(at_[previous_[corner]], at_[corner], at_[next_[corner]]); }

    /// Whether the edges lie on one another, or one has no length.
    bool is_spike(std::size_t corner) const {
        const Position &a = at_[previous_[corner]], &b = at_[corner], &c = at_[next_[corner]];
        return turn(corner) == 0 && (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) >= 0;
    }

    void cut(std::size_t corner) {
        const std::size_t before = previous_[corner], after = next_[corner];
        next_[before] = after;
        previous_[after] = before;
        is_no_ear_[before] = is_no_ear_[after] = false;
        corners_.set(places_[corner], {});
        edges_.set(corner, {});
        edges_.set(before, frame_.box(at_[before], at_[after]));
    }

    /// Whether the triangle of the corner and its neighbours lies in the polygon.
    bool is_ear(std::size_t corner) {
        if (has_given_up() || turn(corner) <= 0) return false;
        --tests_;
        const std::size_t before = previous_[corner], after = next_[corner];
        const Position &a = at_[before], &b = at_[corner], &c = at_[after];
        const auto is_other = [&](std::size_t i) {
            if (i == before || i == corner || i == after) return false;
            steps_ -= std::min(steps_, steps_of_predicates);
            return true;
        };
        // The third side is no diagonal if a corner lies on it or behind it, or if an edge crosses it.
        const Rectangle triangle = box_of({a, b, c}), side = frame_.box(c, a);
        const Position from = frame_.position(c), to = frame_.position(a);
        const auto may_be_in_triangle = [&](const Rectangle& box) {
            return box.meets(triangle) && !is_right_of(box, a, b) && !is_right_of(box, b, c) && !is_right_of(box, c, a);
        };
        const auto may_cross_side = [&](const Rectangle& box) {
            return box.meets(side) && !is_right_of(box, from, to) && !is_right_of(box, to, from);
        };
        const bool has_corner = corners_.any(steps_, may_be_in_triangle, [&](std::size_t place) {
            const std::size_t i = corner_at_[place];
            const Position& p = at_[i];
            return is_other(i) && p != a && p != c && orientation(c, a, p) >= 0 && orientation(a, b, p) > 0 &&
                   orientation(b, c, p) > 0;
        });
        if (has_corner) return false;
        const bool has_edge = edges_.any(steps_, may_cross_side, [&](std::size_t i) {
            const Position &p = at_[i], &q = at_[next_[i]];
            return is_other(i) && orientation(c, a, p) * orientation(c, a, q) < 0 &&
                   orientation(p, q, a) * orientation(p, q, c) < 0;
        });
        return !has_edge && steps_ > 0;
    }

    std::vector<Position> at_;
    std::vector<std::size_t> previous_, next_;
    std::vector<bool> is_no_ear_;         ///< was tested since one of its neighbours changed
    std::vector<std::uint32_t> places_;   ///< of corners, in corners_
    std::vector<std::size_t> corner_at_;  ///< by place
    BoxTree corners_;
    EdgeFrame frame_;
    BoxTree edges_;              ///< an edge has the place of the corner at which it begins
    std::size_t tests_, steps_;  ///< of ears and of the trees, that are left
};

/// Sets the normals of a fan's triangles, as long as twice their areas in units of the square of the polygon's extent.
void set_normals_of_fan(std::span<const Vec3> vertices, const Corners& corners, std::vector<Vec3>& normals) {
    const Vec3& origin = vertices[corners[0]];
    double extent = 0;
    for (const std::uint32_t corner : corners)
        for (std::size_t axis = 0; axis < 3; ++axis)
            extent = std::max(extent, std::abs(vertices[corner][axis] - origin[axis]));
    normals.clear();
    Vec3 before{};
    for (std::size_t k = 1; k < corners.size(); ++k) {
        Vec3 spoke;
        for (std::size_t axis = 0; axis < 3; ++axis) spoke[axis] = (vertices[corners[k]][axis] - origin[axis]) / extent;
        if (k > 1)
            normals.push_back({before[1] * spoke[2] - before[2] * spoke[1], before[2] * spoke[0] - before[0] * spoke[2],
                               before[0] * spoke[1] - before[1] * spoke[0]});
        before = spoke;
    }
}

/// The axis along which the polygon is looked at, and whether its corners run clockwise then. Null if the fan shall
/// stay: it is right, or the polygon has no normal. `normals` is memory for many calls.
std::optional<std::pair<std::size_t, bool>> view_of_ears(std::span<const Vec3> vertices, const Corners& corners,
                                                         std::vector<Vec3>& normals) {
    set_normals_of_fan(vertices, corners, normals);
    Vec3 sum{};
    for (const Vec3& normal : normals)
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += normal[axis];
    const bool is_right = std::ranges::all_of(
        normals, [&](const Vec3& normal) { return normal[0] * sum[0] + normal[1] * sum[1] + normal[2] * sum[2] >= 0; });
    // A coordinate that is not finite is refused later.
    if (is_right || !is_finite(sum)) return std::nullopt;
    std::size_t axis = 0;
    for (std::size_t other = 1; other < 3; ++other)
        if (std::abs(sum[other]) > std::abs(sum[axis])) axis = other;
    return std::pair(axis, sum[axis] < 0);
}

}  // namespace

void Polygons::add(MeshArrays& mesh, std::span<const std::uint32_t> corners) {
    if (corners.size() > 3) fans_.push_back({mesh.triangles.size(), corners.size() - 2});
    mesh.add_polygon(corners);
}

UncutPolygons Polygons::triangulate(MeshArrays& mesh) const {
    UncutPolygons uncut;
    Corners corners;
    std::vector<Vec3> normals;
    for (const Fan& fan : fans_) {
        const auto triangles = std::span(mesh.triangles).subspan(fan.first_triangle, fan.triangles);
        corners.assign({triangles[0][0], triangles[0][1]});
        for (const Triangle& triangle : triangles) corners.push_back(triangle[2]);
        const auto view = view_of_ears(mesh.vertices, corners, normals);
        if (!view) continue;
        const auto [axis, is_clockwise] = *view;
        std::vector<Position> positions;
        for (const std::uint32_t corner : corners) {
            const Vec3& vertex = mesh.vertices[corner];
            Position position{vertex[(axis + 1) % 3], vertex[(axis + 2) % 3]};
            if (is_clockwise) std::swap(position[0], position[1]);
            positions.push_back(position);
        }
        EarCutter cutter(std::move(positions));
        const auto ears = cutter.triangles();
        if (!ears) {
            if (cutter.has_given_up()) uncut.add({1, fan.first_triangle, corners.size()});
            continue;
        }
        std::ranges::transform(*ears, triangles.begin(), [&](const std::array<std::size_t, 3>& ear) -> Triangle {
            return {corners[ear[0]], corners[ear[1]], corners[ear[2]]};
        });
    }
    return uncut;
}

}  // namespace clsdf

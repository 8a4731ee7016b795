#include "scenes/scene_points.hpp"

#include "core/floating_point.hpp"
#include "core/parallel.hpp"
#include "points/curve_order.hpp"
#include "points/point_run.hpp"
#include "scenes/meeting_lines.hpp"
#include "scenes/point_outputs.hpp"
#include "scenes/union_search.hpp"

#include "point_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <tuple>

namespace clsdf::scenes {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t most_in_chunk = most_at_once;

/// What one body says of a point.
struct OfBody {
    points::NearestOfPoint nearest;
    std::uint8_t sign;
};

/// The squared distance with its sign, in the scene's units. A unit is a power of two, so the product is exact.
double value_of(const points::NearestOfPoint& nearest, std::uint8_t sign, double unit) {
    if (sign == CLSDF_POINT_ON_SURFACE) return 0;
    // Rounding may leave nothing of the distance of a point beside the surface.
    const double squared = nearest.face == CLSDF_NO_FACE
                               ? infinity
                               : std::max(nearest.squared * (unit * unit), std::numeric_limits<double>::denorm_min());
    return sign == CLSDF_POINT_INSIDE ? -squared : squared;
}

/// Takes what a body says of a point: the least pair (value, body).
void take(const OfBody& of_body, double unit, std::uint32_t body, Found& found) {
    const double value = value_of(of_body.nearest, of_body.sign, unit);
    if (value == infinity || value > found.value || (value == found.value && body > found.body)) return;
    found.value = value;
    found.body = body;
    found.face = of_body.nearest.face;
    found.sign = of_body.sign;
}

/// Whether all that lies in a box is farther from a point than a computed distance, whatever that was rounded by.
bool is_farther(const Box& box, const Vec3& p, double distance) {
    const double largest = std::max({largest_of(box.lower), largest_of(box.upper), largest_of(p)});
    return distance_to(box, p) * (1 - 1e-13) - 1e-14 * largest > distance;
}

/// Looks up points, at most most_in_chunk, in one body and calls use(i, of_body) for each. A face farther away than
/// most_of(i) is looked for, up to the half width, only if the point is inside. needs_sign(i, nearest): false: the sign
/// does not count, and is outside.
template <typename PointOf, typename MostOf, typename NeedsSign, typename Use>
void look_up(const SearchedBody& body, std::size_t count, double half_width, const PointOf& point_of,
             const MostOf& most_of, const NeedsSign& needs_sign, const Use& use) {
    std::array<Vec3, most_in_chunk> in_body;
    std::array<points::NearestOfPoint, most_in_chunk> nearest;
    std::array<double, most_in_chunk> squared;
    std::array<std::uint8_t, most_in_chunk> signs;
    std::uint32_t near = CLSDF_NO_FACE;
    for (std::size_t i = 0; i < count; ++i) {
        in_body[i] = body.frame->to_body(point_of(i));
        nearest[i] = nearest_within(body, in_body[i], most_of(i), near);
        squared[i] = nearest[i].squared;
        signs[i] = needs_sign(i, nearest[i]) ? CLSDF_POINT_UNDECIDED : CLSDF_POINT_OUTSIDE;
    }
    find_signs(body, std::span(in_body).first(count), std::span(squared).first(count), std::span(signs).first(count));
    for (std::size_t i = 0; i < count; ++i) {
        if (nearest[i].face == CLSDF_NO_FACE && signs[i] == CLSDF_POINT_INSIDE && most_of(i) < half_width)
            nearest[i] = nearest_within(body, in_body[i], half_width, near);
        use(i, OfBody{nearest[i], signs[i]});
    }
}

/// Calls visit(body, first, count) for the runs of equal bodies in a list that is sorted by them.
template <typename Pair, typename Visit>
void for_each_body(const std::vector<Pair>& asked, const Visit& visit) {
    for (std::size_t begin = 0, end = 0; begin < asked.size(); begin = end) {
        while (end < asked.size() && asked[end].body == asked[begin].body) ++end;
        visit(asked[begin].body, begin, end - begin);
    }
}

/// A body whose box holds a point of a chunk, or which has a film.
struct Holder {
    std::uint32_t body;
    std::uint32_t point;  ///< in the chunk
    bool is_first;        ///< the one whose box holds it deepest, which is likely to have the least value
};

/// The points of a chunk.
class Chunk {
public:
    /// chosen: the numbers of its points, at most most_in_chunk.
    Chunk(const SearchedScene& scene, std::span<const Vec3> points, std::span<const std::uint32_t> chosen,
          const HalfWidths& half_widths)
        : scene_(scene), count_(chosen.size()), half_widths_(half_widths) {
        for (std::size_t i = 0; i < count_; ++i) points_[i] = points[chosen[i]];
    }

    void search() {
        for (std::uint32_t i = 0; i < count_; ++i)
            if (is_finite(points_[i])) find_holders(i);
        std::ranges::sort(holders_, {}, [](const Holder& h) { return std::tuple(!h.is_first, h.body, h.point); });
        for_each_body(holders_, [&](std::uint32_t body, std::size_t first, std::size_t count) {
            const double unit = mesh_of(scene_.bodies[body]).lattice.unit;
            const auto found_of = [&](std::size_t i) -> Found& { return found_[holders_[first + i].point]; };
            look_up(
                scene_.bodies[body], count, half_widths_.of(body),
                [&](std::size_t i) { return points_[holders_[first + i].point]; },
                [&](std::size_t i) { return most_of(found_of(i), body); },
                [&](std::size_t i, const points::NearestOfPoint& nearest) {
                    // Otherwise another body is deeper, whatever the sign.
                    return found_of(i).value > 0 || nearest.face == CLSDF_NO_FACE ||
                           value_of(nearest, CLSDF_POINT_INSIDE, unit) <= found_of(i).value;
                },
                [&](std::size_t i, const OfBody& of_body) { take(of_body, unit, body, found_of(i)); });
        });
        for (std::uint32_t i = 0; i < count_; ++i)
            if (found_[i].value > 0 && is_finite(points_[i])) search_outside(i);
    }

    const Found& found(std::size_t i) const { return found_[i]; }

    /// Whether the point has a value: it is finite, and no body that may be nearest is too far to be searched.
    bool is_usable(std::size_t i) const {
        const double distance = std::min(std::sqrt(std::max(found_[i].value, 0.0)), half_widths_.greatest);
        return is_finite(points_[i]) &&
               (!found_[i].is_left_out || found_[i].value <= 0 || found_[i].not_searched > distance);
    }

    /// Whether the value of a point is the distance to the union: closest: of its body.
    bool is_own(std::size_t i, const Vec3& closest) const { return found_[i].value > 0 || is_alone(i, closest); }

    /// Whether the closest point of a point is neither in nor on another body.
    bool is_alone(std::size_t i, const Vec3& closest) const {
        const Found& found = found_[i];
        const SearchedBody& own = scene_.bodies[found.body];
        double largest = std::max(largest_of(own), largest_of(closest));
        largest = std::max(largest, largest_of(points_[i]));
        // Above the rounding of the closest point.
        const double of_own = 1e-9 * mesh_of(own).lattice.unit, rounding = of_own + 1e-13 * largest;
        bool is_alone = true;
        const auto look = [&](std::uint32_t body) {
            const SearchedBody& other = scene_.bodies[body];
            if (!is_alone || body == found.body || other.shape->inputs.sign == SignRule::none) return;
            is_alone =
                place_in(other, closest, of_own + 1e-13 * std::max(largest, largest_of(other))) == PlaceInBody::outside;
        };
        for (const std::uint32_t body : scene_.with_films) look(body);
        scene_.tree.visit_near(closest, rounding, [&](std::uint32_t body) {
            if (!scene_.bodies[body].shape->has_film) look(body);
            return is_alone ? rounding : -1;
        });
        return is_alone;
    }

private:
    /// The bodies that have to tell the sign.
    void find_holders(std::uint32_t point) {
        const std::size_t begin = holders_.size();
        std::size_t first = begin;
        double deepest = -infinity;
        const auto ask = [&](std::uint32_t body) {
            const SearchedBody& searched = scene_.bodies[body];
            const Vec3 in_body = searched.frame->to_body(points_[point]);
            const Box& box = searched.shape->sign_box;
            if (!searched.shape->has_film && !engine::contains(box, in_body)) return;
            if (!scenes::is_usable(searched, in_body)) return leave_out(searched, in_body, found_[point]);
            double depth = infinity;
            for (std::size_t axis = 0; axis < 3; ++axis)
                depth = std::min({depth, in_body[axis] - box.lower[axis], box.upper[axis] - in_body[axis]});
            if (depth > deepest) {
                deepest = depth;
                first = holders_.size();
            }
            holders_.push_back({body, point, false});
        };
        for (const std::uint32_t body : scene_.with_films) ask(body);
        scene_.tree.visit_holding(points_[point], [&](std::uint32_t body) {
            if (!scene_.bodies[body].shape->has_film) ask(body);
        });
        if (first < holders_.size()) holders_[first].is_first = true;
    }

    /// How far a face of another body may be that counts, unless the point is inside that body: if the point is outside
    /// all bodies so far, the least distance, else the greatest depth.
    double most_of(const Found& found) const {
        return std::min(half_widths_.greatest, std::sqrt(std::abs(found.value)));
    }
    double most_of(const Found& found, std::uint32_t body) const {
        return std::min(half_widths_.of(body), std::sqrt(std::abs(found.value)));
    }

    static void leave_out(const SearchedBody& body, const Vec3& in_body, Found& found) {
        found.is_left_out = true;
        found.not_searched = std::min(found.not_searched, distance_to(mesh_of(body).box, in_body) * (1 - 1e-9));
    }

    /// The bodies whose boxes do not hold the point.
    void search_outside(std::uint32_t point) {
        Found& found = found_[point];
        scene_.tree.visit_near(points_[point], most_of(found), [&](std::uint32_t body) {
            const SearchedBody& searched = scene_.bodies[body];
            const Vec3 in_body = searched.frame->to_body(points_[point]);
            const double most = most_of(found, body);
            if (searched.shape->has_film || engine::contains(searched.shape->sign_box, in_body) ||
                is_farther(searched.shape->sign_box, in_body, most))
                return most_of(found);
            if (!scenes::is_usable(searched, in_body)) {
                leave_out(searched, in_body, found);
                return most_of(found);
            }
            if (body != last_.body) last_ = {body, CLSDF_NO_FACE};
            take({nearest_within(searched, in_body, most, last_.near), CLSDF_POINT_OUTSIDE},
                 mesh_of(searched).lattice.unit, body, found);
            return most_of(found);
        });
    }

    const SearchedScene& scene_;
    std::size_t count_;
    std::array<Vec3, most_in_chunk> points_;
    const HalfWidths& half_widths_;
    std::vector<Holder> holders_;
    std::array<Found, most_in_chunk> found_;
    /// The last body of search_outside(), and its face that was the nearest.
    struct {
        std::uint32_t body = no_body, near = CLSDF_NO_FACE;
    } last_;
};

/// Those of all chunks.
class Unusable {
public:
    void add(std::size_t index, bool is_finite) {
        const std::scoped_lock lock(mutex_);
        if (all_.count++ > 0 && all_.first < index) return;
        all_.first = index;
        all_.is_finite = is_finite;
    }
    const UnusableOfScene& all() const { return all_; }

private:
    std::mutex mutex_;
    UnusableOfScene all_;
};

/// The numbers of points in an order in which neighbours are near each other, if they fill more than a chunk. box:
/// around the bodies.
UninitializedVector<std::uint32_t> order_of(std::span<const Vec3> points, Box box) {
    if (points.size() > most_in_chunk) {
        const double margin = box.longest_side() / 8;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.lower[axis] -= margin;
            box.upper[axis] += margin;
        }
        if (std::ranges::all_of(points, is_finite)) return points::curve_order(points, box);
        std::vector<Vec3> finite(points.begin(), points.end());
        std::ranges::replace_if(finite, std::not_fn(is_finite), box.lower);
        return points::curve_order(finite, box);
    }
    UninitializedVector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    return order;
}

/// The distance of a point that is not usable.
double distance_of_unusable(bool is_finite, double half_width) {
    return is_finite && std::isfinite(half_width) ? half_width : std::numeric_limits<double>::quiet_NaN();
}

/// A point whose distance to the union is not that to the nearest body.
struct HiddenPoint {
    std::uint32_t number;
    Found found;  ///< of the nearest body
};

/// The points of all chunks whose closest points another body may hide.
class HiddenPoints {
public:
    void add(std::span<const HiddenPoint> points) {
        if (points.empty()) return;
        const std::scoped_lock lock(mutex_);
        all_.insert(all_.end(), points.begin(), points.end());
    }
    std::span<const HiddenPoint> all() const { return all_; }

private:
    std::mutex mutex_;
    std::vector<HiddenPoint> all_;
};

/// Whether the nearest body may have another distance than the union: the point is inside or, to rounding, on it.
bool may_be_hidden(const SearchedScene& scene, const Found& found, const Vec3& point) {
    if (!scene.meeting_lines || found.face == CLSDF_NO_FACE) return false;
    return found.value <= 0 || std::sqrt(found.value) <= rounding_of(scene.bodies[found.body], point);
}

/// Finds their distances to the union.
void answer_hidden(const SearchedScene& scene, std::span<const Vec3> points, std::span<const HiddenPoint> hidden,
                   const HalfWidths& half_widths, const SceneArrays& results) {
    if (hidden.empty()) return;
    const std::shared_ptr<const MeetingLines> lines = scene.meeting_lines();
    const UnionSearch search(scene, *lines);
    for_each_range(
        hidden.size(),
        [&](std::size_t begin, std::size_t end) {
            const DefaultFloatingPoint as_kernels;
            Outputs outputs(results.arrays);
            for (const auto& [i, found] : hidden.subspan(begin, end - begin)) {
                scene.cancellation.check();
                const Vec3& point = points[i];
                const double rounding = rounding_of(scene.bodies[found.body], point),
                             depth = found.value < 0 ? std::sqrt(-found.value) : 0;
                const UnionSearch::Nearest nearest = search.nearest(point, std::max(depth - rounding, 0.0),
                                                                    std::max(half_widths.greatest, 2 * rounding));
                // A point on the surface of a body is on that of the union, or inside.
                if (found.value >= 0 && nearest.body != no_body && nearest.distance <= 2 * rounding) continue;
                if (results.is_inside != nullptr) results.is_inside[i] = 1;
                if (results.is_own != nullptr) results.is_own[i] = 1;
                if (results.arrays[Output::distance].data == nullptr) continue;
                if (nearest.body == no_body || nearest.distance > half_widths.greatest)
                    outputs.leave(-half_widths.greatest, i);
                else if (nearest.is_cut)
                    outputs.store_cut(scene.bodies[nearest.body], nearest.body, nearest.face, point, nearest.closest,
                                      nearest.distance, i);
                else
                    outputs.store(&scene.bodies[nearest.body],
                                  {.body = nearest.body, .face = nearest.face, .sign = CLSDF_POINT_INSIDE}, point,
                                  half_widths, i);
            }
        },
        4);
}

}  // namespace

UnusableOfScene answer_points(const SearchedScene& scene, std::span<const Vec3> points, const HalfWidths& half_widths,
                              const SceneArrays& results) {
    Unusable unusable;
    HiddenPoints hidden;
    const auto order = order_of(points, scene.tree.box());
    for_each_chunk(points.size(), most_in_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        const DefaultFloatingPoint as_kernels;
        const std::span<const std::uint32_t> chosen(order.data() + begin, end - begin);
        Chunk chunk(scene, points, chosen, half_widths);
        chunk.search();
        Outputs outputs(results.arrays);
        std::vector<HiddenPoint> of_chunk;
        for (std::size_t k = 0; k < chosen.size(); ++k) {
            const std::uint32_t i = chosen[k];
            const Found& found = chunk.found(k);
            if (results.is_inside != nullptr) results.is_inside[i] = found.is_inside() ? 1 : 0;
            bool is_within = false, is_own = false;
            if (!chunk.is_usable(k)) {
                unusable.add(i, is_finite(points[i]));
                outputs.leave(distance_of_unusable(is_finite(points[i]), half_widths.greatest), i);
            } else if (results.arrays[Output::distance].data != nullptr) {
                const SearchedBody* body = found.body == no_body ? nullptr : &scene.bodies[found.body];
                is_within = outputs.store(body, found, points[i], half_widths, i);
                const bool is_doubtful = is_within && may_be_hidden(scene, found, points[i]);
                is_own = (is_doubtful || results.is_own != nullptr) &&
                         (!is_within ||
                          (is_doubtful ? chunk.is_alone(k, outputs.closest()) : chunk.is_own(k, outputs.closest())));
                if (is_doubtful && !is_own) of_chunk.push_back({i, found});
                is_own = is_own || is_doubtful;
            } else if (found.sign == CLSDF_POINT_ON_SURFACE && may_be_hidden(scene, found, points[i]) &&
                       !chunk.is_alone(k, points[i])) {
                of_chunk.push_back({i, found});
            }
            if (results.is_own != nullptr) results.is_own[i] = is_own ? 1 : 0;
        }
        hidden.add(of_chunk);
    });
    answer_hidden(scene, points, hidden.all(), half_widths, results);
    return unusable.all();
}

UnusableOfScene answer_pairs(const SearchedScene& scene, std::span<const Vec3> points, std::span<const Asked> pairs,
                             const HalfWidths& half_widths, const targets::HostArrays& arrays) {
    Unusable unusable;
    for_each_chunk(pairs.size(), most_in_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        const DefaultFloatingPoint as_kernels;
        Outputs outputs(arrays);
        std::vector<Asked> usable;  // whose points are places among the pairs
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3& point = points[pairs[i].point];
            const SearchedBody& body = scene.bodies[pairs[i].body];
            if (is_finite(point) && is_usable(body, body.frame->to_body(point))) {
                usable.push_back({static_cast<std::uint32_t>(i - begin), pairs[i].body});
            } else {
                unusable.add(i, is_finite(point));
                outputs.leave(distance_of_unusable(is_finite(point), half_widths.of(pairs[i].body)), i);
            }
        }
        std::ranges::sort(usable, {}, [](const Asked& asked) { return std::pair(asked.body, asked.point); });
        for_each_body(usable, [&](std::uint32_t number, std::size_t first, std::size_t count) {
            const SearchedBody& body = scene.bodies[number];
            const double half_width = half_widths.of(number);
            const HalfWidths own{std::span(&half_width, 1), half_width};
            const auto place = [&](std::size_t i) { return begin + usable[first + i].point; };
            const auto point_of = [&](std::size_t i) { return points[pairs[place(i)].point]; };
            look_up(
                body, count, half_width, point_of, [&](std::size_t) { return half_width; },
                [](std::size_t, const points::NearestOfPoint&) { return true; },
                [&](std::size_t i, const OfBody& of_body) {
                    outputs.store(&body, {.body = number, .face = of_body.nearest.face, .sign = of_body.sign},
                                  point_of(i), own, place(i));
                });
        });
    });
    return unusable.all();
}

}  // namespace clsdf::scenes

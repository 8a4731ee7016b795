#include "scenes/scene_points.hpp"

#include "core/floating_point.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "points/curve_order.hpp"
#include "points/point_run.hpp"
#include "points/signs_by_host.hpp"
#include "tree/wide_tree.hpp"

#include "point_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <tuple>

namespace clsdf::scenes {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t most_in_chunk = 64;

bool is_finite(const Vec3& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// What is known of a point.
struct Found {
    /// The least signed distance so far, squared, with its sign, in the scene's units: infinite beyond the half width.
    double value = infinity;
    std::uint32_t body = no_body;  ///< whose value is the least, or inside which the point lies beyond the half width
    std::uint32_t face = CLSDF_NO_FACE;
    std::uint8_t sign = CLSDF_POINT_OUTSIDE;
    bool is_left_out = false;        ///< a body is too far away to be searched
    double not_searched = infinity;  ///< the least distance from the boxes of such bodies

    bool is_inside() const { return sign == CLSDF_POINT_INSIDE; }
};

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

const engine::PointMesh& mesh_of(const SearchedBody& body) {
    return *body.shape->inputs.on_host;
}

double largest_of(const Vec3& p) {
    return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
}

/// The largest coordinate of a body, in its own frame and of its translation.
double largest_of(const SearchedBody& body) {
    const Box& box = mesh_of(body).box;
    return std::max({largest_of(box.lower), largest_of(box.upper), largest_of(body.frame->translation)});
}

/// Whether all that lies in a box is farther from a point than a computed distance, whatever that was rounded by.
bool is_farther(const Box& box, const Vec3& p, double distance) {
    const double largest = std::max({largest_of(box.lower), largest_of(box.upper), largest_of(p)});
    return distance_to(box, p) * (1 - 1e-13) - 1e-14 * largest > distance;
}

bool is_usable(const SearchedBody& body, const Vec3& in_body) {
    return engine::contains(body.shape->usable.limits, in_body);
}

/// A search within a half width in a body that need not decide signs.
points::NearestOfPoint nearest_within(const SearchedBody& body, const Vec3& in_body, double half_width,
                                      std::uint32_t& near) {
    const engine::PointMesh& mesh = mesh_of(body);
    return points::find_nearest(body.shape->inputs, mesh.in_units(in_body), points::search_limit(mesh, half_width),
                                near);
}

/// Those of the points in a body that are CLSDF_POINT_UNDECIDED.
void find_signs(const SearchedBody& body, std::span<const Vec3> in_body, std::span<const double> squared,
                std::span<std::uint8_t> signs) {
    std::array<std::uint32_t, most_in_chunk> order;
    for (std::size_t i = 0; i < in_body.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
    points::find_signs({mesh_of(body), *body.shape->inputs.leaves->tree}, body.shape->inputs.sign,
                       {in_body, std::span(order).first(in_body.size()), squared}, signs);
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

/// The outputs of one point by one body, in double, and then in the scene's coordinates.
class Outputs {
public:
    /// wanted: the outputs of all points.
    explicit Outputs(const targets::HostArrays& wanted) : wanted_(wanted) {
        std::size_t used = 0;
        for_each_output(
            [&](const OutputInfo& info, targets::HostArray& array, const targets::HostArray& asked) {
                // The distance is NaN unless it is written, and the closest point beyond the half width.
                array.is_wanted = asked.is_wanted || info.output == Output::distance || info.output == Output::closest;
                array.in_double = may_be_double(info);
                array.data = reinterpret_cast<std::byte*>(room_.data() + used);
                used += info.components;
            },
            arrays_, wanted);
    }

    Vec3 closest() const {
        Vec3 result;
        std::memcpy(result.data(), arrays_[Output::closest].data, sizeof result);
        return result;
    }

    /// Stores the outputs of a point at its place among all. Returns whether it is within the half width, and has set
    /// closest() then, in the scene's coordinates.
    bool store(const SearchedBody* body, const Found& found, const Vec3& point, const HalfWidths& half_widths,
               std::size_t at) {
        bool is_within = false;
        if (found.face != CLSDF_NO_FACE) {
            const Vec3 in_units = mesh_of(*body).in_units(body->frame->to_body(point));
            points::finish_on_host(*body->shape->finishing, in_units, found.face, found.sign,
                                   half_widths.of(found.body), arrays_);
            is_within = is_finite(closest());
        }
        if (is_within) {
            std::memcpy(arrays_[Output::body].data, &found.body, sizeof found.body);
            turn(Output::closest, *body->frame);
            if (wanted_[Output::gradient].is_wanted) turn(Output::gradient, *body->frame);
            if (wanted_[Output::offset].is_wanted) turn(Output::offset, *body->frame);
            copy(at);
        } else {
            leave(found.is_inside() ? -half_widths.greatest : half_widths.greatest, at);
        }
        return is_within;
    }

    /// Stores those of a point beyond the half width.
    void leave(double distance, std::size_t at) const {
        for_each_output(
            [&](const OutputInfo& info, const targets::HostArray& to) {
                if (to.data == nullptr) return;
                const std::size_t bytes = sample_bytes(info, to.in_double);
                if (info.output != Output::distance)
                    std::memset(to.data + at * bytes, 0xFF, bytes);
                else
                    store_numbers(&distance, 1, to, at);
            },
            wanted_);
    }

private:
    static void store_numbers(const double* numbers, std::size_t components, const targets::HostArray& to,
                              std::size_t at) {
        for (std::size_t c = 0; c < components; ++c) {
            const std::size_t place = at * components + c;
            const auto rounded = static_cast<float>(numbers[c]);
            if (to.in_double)
                std::memcpy(to.data + place * sizeof(double), numbers + c, sizeof(double));
            else
                std::memcpy(to.data + place * sizeof(float), &rounded, sizeof(float));
        }
    }

    void turn(Output output, const Frame& frame) {
        Vec3 vector;
        std::memcpy(vector.data(), arrays_[output].data, sizeof vector);
        vector = output == Output::closest ? frame.to_scene(vector) : frame.turned(vector);
        std::memcpy(arrays_[output].data, vector.data(), sizeof vector);
    }

    void copy(std::size_t at) const {
        for_each_output(
            [&](const OutputInfo& info, const targets::HostArray& from, const targets::HostArray& to) {
                if (to.data == nullptr) return;
                if (!may_be_double(info)) {
                    const std::size_t bytes = sample_bytes(info, true);
                    std::memcpy(to.data + at * bytes, from.data, bytes);
                    return;
                }
                std::array<double, 3> numbers;
                std::memcpy(numbers.data(), from.data, info.components * sizeof(double));
                // As finish_point() rounds: a distance that is not 0 stays so.
                constexpr double least = std::numeric_limits<float>::denorm_min();
                if (info.output == Output::distance && !to.in_double && numbers[0] != 0 &&
                    static_cast<float>(numbers[0]) == 0)
                    numbers[0] = std::copysign(least, numbers[0]);
                store_numbers(numbers.data(), info.components, to, at);
            },
            arrays_, wanted_);
    }

    const targets::HostArrays& wanted_;
    targets::HostArrays arrays_;
    std::array<double, 3 * CLSDF_OUTPUT_COUNT> room_{};
};

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
    bool is_own(std::size_t i, const Vec3& closest) const {
        const Found& found = found_[i];
        if (found.value > 0) return true;
        const SearchedBody& own = scene_.bodies[found.body];
        double largest = std::max(largest_of(own), largest_of(closest));
        largest = std::max(largest, largest_of(points_[i]));
        // Above the rounding of the closest point.
        const double of_own = 1e-9 * mesh_of(own).lattice.unit, rounding = of_own + 1e-13 * largest;
        bool is_alone = true;
        const auto look = [&](std::uint32_t body) {
            const SearchedBody& other = scene_.bodies[body];
            if (!is_alone || body == found.body || other.shape->inputs.sign == SignRule::none) return;
            is_alone = !is_in_or_on(other, closest, of_own + 1e-13 * std::max(largest, largest_of(other)));
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

    static bool is_in_or_on(const SearchedBody& body, const Vec3& point, double rounding) {
        const Vec3 in_body = body.frame->to_body(point);
        if (!scenes::is_usable(body, in_body)) return false;
        std::uint32_t near = CLSDF_NO_FACE;
        const points::NearestOfPoint nearest = nearest_within(body, in_body, rounding, near);
        const double most = rounding / mesh_of(body).lattice.unit;
        if (nearest.face != CLSDF_NO_FACE && nearest.squared <= most * most) return true;
        std::uint8_t sign = CLSDF_POINT_UNDECIDED;
        scenes::find_signs(body, std::span(&in_body, 1), std::span(&nearest.squared, 1), std::span(&sign, 1));
        return sign != CLSDF_POINT_OUTSIDE;
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

}  // namespace

UnusableOfScene answer_points(const SearchedScene& scene, std::span<const Vec3> points, const HalfWidths& half_widths,
                              const SceneArrays& results) {
    Unusable unusable;
    const auto order = order_of(points, scene.tree.box());
    for_each_chunk(points.size(), most_in_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        const DefaultFloatingPoint as_kernels;
        const std::span<const std::uint32_t> chosen(order.data() + begin, end - begin);
        Chunk chunk(scene, points, chosen, half_widths);
        chunk.search();
        Outputs outputs(results.arrays);
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
                is_own = results.is_own != nullptr && (!is_within || chunk.is_own(k, outputs.closest()));
            }
            if (results.is_own != nullptr) results.is_own[i] = is_own ? 1 : 0;
        }
    });
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

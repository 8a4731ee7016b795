#include <clsdf/scene.hpp>

#include "calls/scenes/scene_state.hpp"
#include "calls/transform/transform_access.hpp"
#include "calls/transform/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "points/box_places.hpp"
#include "points/usable_points.hpp"
#include "scenes/scene_points.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/output_targets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace clsdf {

/// What points are looked up with, of all bodies that are on.
class Scene::State::Call {
public:
    Call(State& state, OutputSet outputs, std::size_t count, calls::RunningCall& running)
        : state_(state),
          cancellation_(running.options.should_stop, "the query"),
          tree_(state.current_tree()),
          bodies_(state.bodies.size()) {
        for (std::uint32_t i = 0; i < state.bodies.size(); ++i) {
            const Body& body = state.bodies[i];
            if (!body.is_active) continue;
            bodies_[i] = {&shape_of(*body.shape, outputs, count, running), &body.frame};
            running.statistics.triangles += bodies_[i].shape->inputs.mesh->count;
            if (bodies_[i].shape->has_film) with_films_.push_back(i);
        }
    }

    scenes::SearchedScene scene() const {
        scenes::SearchedScene scene{bodies_, *tree_, with_films_, cancellation_};
        if (state_.is_union())
            scene.meeting_lines = [this] {
                const std::scoped_lock lock(state_.mutex);
                if (!state_.meeting_lines)
                    state_.meeting_lines = std::make_shared<const scenes::MeetingLines>(
                        scenes::SearchedScene{bodies_, *tree_, with_films_, cancellation_});
                return state_.meeting_lines;
            };
        return scene;
    }

    /// Calls use(scene) with the bodies at other poses.
    template <typename Use>
    void with_frames(const State& state, std::span<const scenes::Frame> frames, const Use& use) const {
        const scenes::BodyTree tree = state.tree_at(frames);
        std::vector<scenes::SearchedBody> bodies = bodies_;
        for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].frame = &frames[i];
        scenes::SearchedScene scene{bodies, tree, with_films_, cancellation_};
        std::shared_ptr<const scenes::MeetingLines> lines;
        if (state.is_union())
            scene.meeting_lines = [&] {
                if (!lines)
                    lines = std::make_shared<const scenes::MeetingLines>(
                        scenes::SearchedScene{bodies, tree, with_films_, cancellation_});
                return lines;
            };
        use(scene);
    }

private:
    const scenes::SearchedShape& shape_of(const Shape& shape, OutputSet outputs, std::size_t count,
                                          calls::RunningCall& running) {
        const auto [place, is_new] = shapes_.try_emplace(&shape);
        scenes::SearchedShape& searched = place->second;
        if (!is_new) return searched;
        auto& state = detail::TransformAccess::state(shape.transform);
        searched.inputs = state.inputs_of_few(outputs, count, running, [&](const Box&) { running.throw_if_stopped(); });
        const engine::PointMesh& mesh = *searched.inputs.on_host;
        searched.sign_box = mesh.sign_box();
        searched.usable = points::usable_range(mesh.box);
        searched.finishing.emplace(points::finishing_sources(searched.inputs));
        searched.has_film = mesh.film != nullptr;
        return searched;
    }

    State& state_;
    cutting::Cancellation cancellation_;
    std::shared_ptr<const scenes::BodyTree> tree_;
    std::vector<scenes::SearchedBody> bodies_;
    std::vector<std::uint32_t> with_films_;
    std::unordered_map<const Shape*, scenes::SearchedShape> shapes_;
};

namespace {

/// Of a call: their places are kept as numbers of 64 bits, with room to add.
constexpr std::size_t most_results = std::size_t{1} << 48;

void check_length(std::size_t length, std::size_t count, const char* name, bool may_be_empty) {
    if (length == count || (may_be_empty && length == 0)) return;
    refuse("the array {} has {} items for {} points; give as many", name, length, count);
}

targets::WrittenArray array_of(std::uintptr_t first, std::size_t bytes, const char* name) {
    targets::WrittenArray array;
    array.first = first;
    array.width = bytes;
    array.name = name;
    return array;
}

template <typename Item>
void add_written(std::span<Item> items, const char* name, std::vector<targets::WrittenArray>& written) {
    if (!items.empty())
        written.push_back(array_of(reinterpret_cast<std::uintptr_t>(items.data()), items.size_bytes(), name));
}

/// The points and the arrays of results of a call, in memory of the host while it lasts.
class PointsOfCall {
public:
    /// results: items of an array; others: the bytes of the call's other arrays.
    PointsOfCall(const device::Context& context, const InputArray& points, const OutputTargets& targets,
                 std::size_t results, std::vector<targets::WrittenArray> others, const CallOptions& call)
        : memory_(context) {
        for (const auto& [output, array] : targets.all())
            if (array.strides[1] != 0 || array.strides[2] != 0)
                refuse(
                    "the array of the output {} has the strides ({}, {}, {}); points lie in one "
                    "row: set strides[0] alone",
                    info_of(output).name, array.strides[0], array.strides[1], array.strides[2]);
        memory_.add_triples(points, "points");
        targets::add_targets(targets, targets::row_of(results), memory_);
        memory_.map(call.wait_list);
        positions_.emplace(memory_.mapped(points));
        targets_.emplace(targets::on_host(targets, targets::row_of(results), memory_), targets::row_of(results),
                         "there are {} points");
        targets_->add_written(0, others);
        targets::refuse_overlap(others);
        // The outputs of some points may lie on others.
        const std::span<const Vec3> all = positions_->get();
        others.push_back(array_of(reinterpret_cast<std::uintptr_t>(all.data()), all.size_bytes(), "the points"));
        if (targets::find_overlap(others)) copy_.assign(all.begin(), all.end());
    }

    std::span<const Vec3> points() const { return copy_.empty() ? positions_->get() : std::span<const Vec3>(copy_); }
    const targets::HostTargets& results() const { return *targets_; }
    void unmap() { memory_.unmap(); }

private:
    targets::MappedMemory memory_;
    std::optional<PositionArray> positions_;
    std::optional<targets::HostTargets> targets_;
    std::vector<Vec3> copy_;
};

void check_one_a_body(std::span<const double> half_widths, std::size_t bodies) {
    if (half_widths.size() != bodies)
        refuse("there are {} half widths and {} bodies; give as many", half_widths.size(), bodies);
}

/// Those of a call, which may be negative.
class CheckedHalfWidths {
public:
    explicit CheckedHalfWidths(std::span<const double> given) : each_(given.begin(), given.end()) {
        for (double& half_width : each_) {
            points::check_half_width(half_width);
            half_width = std::abs(half_width);
            greatest_ = std::max(greatest_, half_width);
        }
    }
    scenes::HalfWidths get() const { return {each_, greatest_}; }

private:
    std::vector<double> each_;
    double greatest_ = 0;
};

/// Calls use(begin, count) for consecutive parts of [0, all); between them the call may be stopped.
template <typename Use>
void for_each_batch(std::size_t all, calls::RunningCall& running, const Use& use) {
    constexpr std::size_t most = std::size_t{1} << 14;
    for (std::size_t begin = 0; begin < all; begin += most) {
        running.throw_if_stopped();
        running.report({.fraction = static_cast<double>(begin) / static_cast<double>(all)});
        use(begin, std::min(most, all - begin));
    }
}

/// Computes results batch after batch: answer(begin, count, arrays) into packed arrays.
template <typename Answer>
scenes::UnusableOfScene in_batches(const targets::HostTargets& targets, std::size_t all, calls::RunningCall& running,
                                   const Answer& answer) {
    scenes::UnusableOfScene unusable;
    targets::OwnArrays own;
    for_each_batch(all, running, [&](std::size_t begin, std::size_t count) {
        const targets::HostArrays arrays =
            targets.are_packed ? targets::arrays_from(begin, targets.arrays) : own.for_samples(targets.arrays, count);
        const scenes::UnusableOfScene found = answer(begin, count, arrays);
        if (found.count > 0 && unusable.count == 0) {
            unusable.first = begin + found.first;
            unusable.is_finite = found.is_finite;
        }
        unusable.count += found.count;
        if (!targets.are_packed) targets.store(targets::row_of(count, begin), arrays);
    });
    return unusable;
}

std::string describe(const scenes::UnusableOfScene& unusable, const char* what, const Vec3& p) {
    return fmt::format("{} {}, counted from 0, at ({}, {}, {}), {}", what, unusable.first, p[0], p[1], p[2],
                       unusable.is_finite ? "lies too far from a body that may be the nearest" : "is not finite");
}

/// Refuses points that are not usable, or returns a warning.
std::string warning_of(const scenes::UnusableOfScene& unusable, std::size_t all, const char* what, const Vec3& first,
                       const CallOptions& call) {
    if (unusable.count == 0) return {};
    const std::string text = describe(unusable, what, first);
    if (call.refuse_unusable_points) throw Error(ErrorCode::invalid_argument, text + "; leave it out");
    return fmt::format("{} of {} {}s have no triangle, and the half width or NaN as their distance; the first, {}",
                       unusable.count, all, what, text);
}

}  // namespace

TransformStatistics Scene::query(const InputArray& points, double half_width, const SceneTargets& targets,
                                 const CallOptions& call) const {
    return with_host_memory("for the points; give fewer at once", [&] {
        return state().query(points, {}, std::span(&half_width, 1), targets, call).published();
    });
}

TransformStatistics Scene::query(const InputArray& points, std::span<const double> half_widths,
                                 const SceneTargets& targets, const CallOptions& call) const {
    return with_host_memory("for the points; give fewer at once", [&] {
        check_one_a_body(half_widths, size());
        if (state().is_union())
            refuse(
                "a half width for each body is given in a scene whose surface is outer, which is one surface of "
                "all bodies; give one half width");
        if (!targets.is_own.empty())
            refuse(
                "is_own is asked for with a half width for each body; bodies beyond theirs do not count, so "
                "give one for all, or leave is_own out");
        return state().query(points, {}, half_widths, targets, call).published();
    });
}

TransformStatistics Scene::query_poses(const InputArray& points, std::span<const Pose> poses, double half_width,
                                       const SceneTargets& targets, const CallOptions& call) const {
    return with_host_memory("for the points; give fewer at once", [&] {
        State& state = this->state();
        state.require_bodies();
        const std::size_t bodies = state.bodies.size();
        if (poses.size() % bodies != 0)
            refuse("there are {} poses and {} bodies; give as many for each configuration", poses.size(), bodies);
        std::vector<scenes::Frame> frames(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i)
            frames[i] = frame_of(poses[i], fmt::format(" of body {} in configuration {}", i % bodies, i / bodies));
        return state.query(points, frames, std::span(&half_width, 1), targets, call).published();
    });
}

CallStatistics Scene::State::query(const InputArray& points, std::optional<std::span<const scenes::Frame>> frames,
                                   std::span<const double> half_widths, const SceneTargets& targets,
                                   const CallOptions& call) {
    require_bodies();
    const CheckedHalfWidths widths(half_widths);
    check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
    const std::size_t configurations = frames ? frames->size() / bodies.size() : 1;
    if (points.count > 0 && configurations > most_results / points.count)
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("{} configurations of {} points are more results than one call has; give fewer at once",
                                configurations, points.count));
    const std::size_t results = configurations * points.count;
    check_length(targets.is_own.size(), results, "is_own", true);
    calls::RunningCall running{call};
    if (results == 0) return running.finish();
    std::vector<targets::WrittenArray> own;
    add_written(targets.is_own, "the array is_own", own);
    PointsOfCall arrays(context(), points, targets.outputs, results, std::move(own), call);
    const std::span<const Vec3> all = arrays.points();
    const Call searched(*this, targets::outputs_of(targets.outputs), results, running);
    // The results [begin, begin + count) of one configuration or of several.
    const auto answer = [&](std::size_t begin, std::size_t count, const targets::HostArrays& to) {
        const auto of_points = [&](const scenes::SearchedScene& scene, std::size_t first, std::size_t end) {
            scenes::SceneArrays here{targets::arrays_from(first - begin, to)};
            if (!targets.is_own.empty()) here.is_own = targets.is_own.data() + first;
            scenes::UnusableOfScene unusable =
                scenes::answer_points(scene, all.subspan(first % all.size(), end - first), widths.get(), here);
            unusable.first += first - begin;
            return unusable;
        };
        if (!frames) return of_points(searched.scene(), begin, begin + count);
        const std::size_t first = begin / all.size(), last = (begin + count - 1) / all.size();
        std::vector<scenes::UnusableOfScene> found(last + 1 - first);
        for_each_index(
            found.size(),
            [&](std::size_t i) {
                const std::size_t number = first + i;
                searched.with_frames(*this, frames->subspan(number * bodies.size(), bodies.size()),
                                     [&](const scenes::SearchedScene& scene) {
                                         found[i] = of_points(scene, std::max(begin, number * all.size()),
                                                              std::min(begin + count, (number + 1) * all.size()));
                                     });
            },
            1);
        scenes::UnusableOfScene sum;
        for (const scenes::UnusableOfScene& of_one : found) {
            if (of_one.count > 0 && sum.count == 0) sum = {0, of_one.first, of_one.is_finite};
            sum.count += of_one.count;
        }
        return sum;
    };
    const scenes::UnusableOfScene unusable = in_batches(arrays.results(), results, running, answer);
    const std::string warning = warning_of(unusable, results, "point", all[unusable.first % all.size()], call);
    running.statistics.unusable_points = unusable.count;
    arrays.unmap();
    if (call.log && !warning.empty()) call.log(warning);
    return running.finish();
}

TransformStatistics Scene::query_pairs(const InputArray& points, std::span<const PointOfBody> pairs, double half_width,
                                       const OutputTargets& targets, const CallOptions& call) const {
    return with_host_memory("for the pairs; give fewer at once", [&] {
        return state().query_pairs(points, pairs, std::span(&half_width, 1), targets, call).published();
    });
}

TransformStatistics Scene::query_pairs(const InputArray& points, std::span<const PointOfBody> pairs,
                                       std::span<const double> half_widths, const OutputTargets& targets,
                                       const CallOptions& call) const {
    return with_host_memory("for the pairs; give fewer at once", [&] {
        check_one_a_body(half_widths, size());
        return state().query_pairs(points, pairs, half_widths, targets, call).published();
    });
}

CallStatistics Scene::State::query_pairs(const InputArray& points, std::span<const PointOfBody> pairs,
                                         std::span<const double> half_widths, const OutputTargets& targets,
                                         const CallOptions& call) {
    require_bodies();
    const CheckedHalfWidths widths(half_widths);
    check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
    std::vector<scenes::Asked> asked(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto [point, body] = pairs[i];
        if (point >= points.count) refuse("pair {} names point {}, and there are {}", i, point, points.count);
        if (body >= bodies.size() || !bodies[body].is_active)
            refuse("pair {} names body {}, which {}", i, body,
                   body < bodies.size() ? std::string("is switched off")
                                        : fmt::format("is not there: the scene has {}", bodies.size()));
        asked[i] = {point, body};
    }
    calls::RunningCall running{call};
    if (pairs.empty()) return running.finish();
    PointsOfCall arrays(context(), points, targets, pairs.size(), {}, call);
    const std::span<const Vec3> all = arrays.points();
    const Call searched(*this, targets::outputs_of(targets), pairs.size(), running);
    const scenes::UnusableOfScene unusable =
        in_batches(arrays.results(), pairs.size(), running,
                   [&](std::size_t begin, std::size_t count, const targets::HostArrays& to) {
                       return scenes::answer_pairs(searched.scene(), all, std::span(asked).subspan(begin, count),
                                                   widths.get(), to);
                   });
    const std::string warning = warning_of(unusable, pairs.size(), "pair", all[asked[unusable.first].point], call);
    running.statistics.unusable_points = unusable.count;
    arrays.unmap();
    if (call.log && !warning.empty()) call.log(warning);
    return running.finish();
}

void Scene::contains(const InputArray& points, std::span<std::uint8_t> is_inside, const CallOptions& call) const {
    with_host_memory("for the points; give fewer at once", [&] {
        State& state = this->state();
        state.require_bodies();
        check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
        check_length(is_inside.size(), points.count, "is_inside", false);
        if (points.count == 0) return;
        targets::MappedMemory memory(state.context());
        memory.add_triples(points, "points");
        memory.map(call.wait_list);
        const PositionArray positions(memory.mapped(points));
        calls::RunningCall running{call};
        const State::Call searched(state, {}, points.count, running);
        const std::span<const Vec3> all = positions.get();
        for_each_batch(all.size(), running, [&](std::size_t begin, std::size_t count) {
            scenes::SceneArrays results;
            results.is_inside = is_inside.data() + begin;
            constexpr double none = 0;
            scenes::answer_points(searched.scene(), all.subspan(begin, count), {std::span(&none, 1), none}, results);
        });
        memory.unmap();
        running.finish();
    });
}

void Scene::winding(const InputArray& points, std::span<double> results, const CallOptions& call) const {
    with_host_memory("for the points; give fewer at once", [&] {
        State& state = this->state();
        state.require_bodies();
        check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
        check_length(results.size(), points.count, "results", false);
        if (points.count == 0) return;
        targets::MappedMemory memory(state.context());
        memory.add_triples(points, "points");
        memory.map(call.wait_list);
        const PositionArray positions(memory.mapped(points));
        const std::span<const Vec3> all = positions.get();
        std::vector<double> sums(all.size()), of_body(all.size());
        std::vector<Vec3> in_body(all.size());
        const auto active = static_cast<double>(std::ranges::count_if(state.bodies, &State::Body::is_active));
        double done = 0;
        for (const State::Body& body : state.bodies) {
            if (!body.is_active) continue;
            std::ranges::transform(all, in_body.begin(), [&](const Vec3& p) { return body.frame.to_body(p); });
            CallOptions part = calls::part_of(call, done / active, (done + 1) / active);
            part.wait_list = {};
            body.shape->transform.winding(in_body, of_body, part);
            ++done;
            for (std::size_t i = 0; i < all.size(); ++i) sums[i] += of_body[i];
        }
        std::ranges::copy(sums, results.begin());
        memory.unmap();
    });
}

void Scene::classify(std::span<const Box> boxes, double half_width, std::span<BoxPlace> places) const {
    with_host_memory("for the boxes; give fewer at once", [&] {
        State& state = this->state();
        state.require_bodies();
        if (places.size() != boxes.size())
            refuse("{} boxes have {} places for their answers; give as many", boxes.size(), places.size());
        points::check_boxes(boxes);
        points::check_half_width(half_width);
        std::ranges::fill(places, has_sign() ? BoxPlace::outside : BoxPlace::beyond);
        std::vector<Box> in_body;
        std::vector<std::size_t> numbers;
        std::vector<BoxPlace> of_body;
        for (const State::Body& body : state.bodies) {
            if (!body.is_active) continue;
            in_body.clear();
            numbers.clear();
            for (std::size_t i = 0; i < boxes.size(); ++i) {
                if (places[i] == BoxPlace::inside) continue;
                const Box box = is_moved(body.frame) ? body.frame.to_body(boxes[i]) : boxes[i];
                if (!std::isfinite(box.lower[0] + box.lower[1] + box.lower[2] + box.upper[0] + box.upper[1] +
                                   box.upper[2])) {
                    places[i] = BoxPlace::within;  // so large that it meets everything
                    continue;
                }
                in_body.push_back(box);
                numbers.push_back(i);
            }
            of_body.resize(in_body.size());
            body.shape->transform.classify(in_body, half_width, of_body);
            for (std::size_t k = 0; k < numbers.size(); ++k)
                if (of_body[k] == BoxPlace::inside || of_body[k] == BoxPlace::within) places[numbers[k]] = of_body[k];
        }
    });
}

}  // namespace clsdf

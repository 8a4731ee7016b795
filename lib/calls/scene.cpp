#include <clsdf/scene.hpp>

#include "calls/transform_access.hpp"
#include "calls/transform_state.hpp"
#include "core/large_memory.hpp"
#include "points/box_places.hpp"
#include "points/usable_points.hpp"
#include "scenes/body_tree.hpp"
#include "scenes/frame.hpp"
#include "scenes/scene_points.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/output_targets.hpp"
#include "targets/target_layout.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <list>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// The mesh of one or more bodies.
struct Shape {
    DistanceTransform transform;
    Box box;
};

struct Body {
    Shape* shape;
    scenes::Frame frame;
    bool is_active;
};

/// Throws Error(invalid_argument) that names the body, if it is one of a scene.
scenes::Frame frame_of(const Pose& pose, std::optional<std::size_t> body = {}) {
    const auto whose = [&] { return body ? fmt::format(" of body {}", *body) : std::string(); };
    for (const double t : pose.translation)
        if (!std::isfinite(t))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the translation{} is ({}, {}, {}), and must be finite", whose(),
                                    pose.translation[0], pose.translation[1], pose.translation[2]));
    const std::optional<scenes::Rotation> rotation = scenes::nearest_rotation(pose.rotation);
    if (!rotation)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the matrix{} is no rotation to 1e-5, or is a reflection; its rows must be unit "
                                "vectors at right angles, and its determinant 1",
                                whose()));
    scenes::Frame frame{*rotation, pose.translation};
    frame.is_turned = frame.rotation != scenes::Frame().rotation;
    return frame;
}

}  // namespace

Pose pose_of(std::span<const double, 16> matrix) {
    const std::span last = matrix.last<4>();
    if (last[0] != 0 || last[1] != 0 || last[2] != 0 || last[3] != 1)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the last row of the 4 x 4 matrix is {}, {}, {}, {}, and must be 0, 0, 0, 1; give the "
                                "matrix by rows",
                                last[0], last[1], last[2], last[3]));
    Pose pose;
    for (std::size_t row = 0; row < 3; ++row) {
        std::copy_n(matrix.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, pose.rotation[row].begin());
        pose.translation[row] = matrix[4 * row + 3];
    }
    const scenes::Frame frame = frame_of(pose);
    return {frame.rotation, frame.translation};
}

struct Scene::State {
    State(Device device_in, const SceneOptions& options_in) : device(std::move(device_in)), options(options_in) {}

    Device device;
    SceneOptions options;
    std::list<Shape> shapes{};
    std::vector<Body> bodies{};

    std::mutex mutex{};
    std::shared_ptr<const scenes::BodyTree> tree{};  ///< null after a change; guarded by the mutex

    const device::Context& context() const { return device::context_of(device); }

    const Body& body(std::uint32_t number) const {
        if (number >= bodies.size())
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("there is no body {}: the scene has {}, counted from 0", number, bodies.size()));
        return bodies[number];
    }
    Body& body(std::uint32_t number) {
        std::as_const(*this).body(number);
        return bodies[number];
    }

    void require_bodies() const {
        if (bodies.empty()) throw Error(ErrorCode::invalid_argument, "the scene has no bodies; add one");
        if (std::ranges::none_of(bodies, &Body::is_active))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("all {} bodies of the scene are switched off; switch one on", bodies.size()));
    }

    std::shared_ptr<const scenes::BodyTree> current_tree() {
        const std::scoped_lock lock(mutex);
        if (tree) return tree;
        std::vector<Box> boxes;
        std::vector<std::uint32_t> numbers;
        for (std::uint32_t i = 0; i < bodies.size(); ++i)
            if (bodies[i].is_active) {
                boxes.push_back(bodies[i].frame.to_scene(bodies[i].shape->box));
                numbers.push_back(i);
            }
        return tree = std::make_shared<const scenes::BodyTree>(boxes, numbers);
    }

    template <typename MeshOrView>
    std::uint32_t add(const MeshOrView& mesh, const Pose& pose, SignRule sign, const CallOptions& call) {
        if (sign == SignRule::below)
            throw Error(ErrorCode::unsupported,
                        "the sign rule below has walls along z, which do not turn with a body of a scene; close_down() "
                        "makes a closed mesh");
        return add_body(pose, [&]() -> Shape& {
            DistanceTransform transform(device, mesh, {.sign = sign, .kept_bytes = options.kept_bytes}, call);
            const Box box = transform.box();
            return shapes.emplace_back(Shape{std::move(transform), box});
        });
    }

    template <typename MakeShape>
    std::uint32_t add_body(const Pose& pose, const MakeShape& make_shape) {
        if (bodies.size() >= no_body)
            throw Error(ErrorCode::unsupported, fmt::format("a scene has at most {} bodies", no_body));
        const scenes::Frame frame = frame_of(pose, bodies.size());
        if (bodies.size() == bodies.capacity()) bodies.reserve(2 * bodies.size() + 1);  // so that nothing fails below
        bodies.push_back({&make_shape(), frame, true});
        tree.reset();
        return static_cast<std::uint32_t>(bodies.size() - 1);
    }

    class Call;
};

/// What points are looked up with, of all bodies that are on.
class Scene::State::Call {
public:
    Call(State& state, OutputSet outputs, std::size_t count, calls::RunningCall& running)
        : tree_(state.current_tree()), bodies_(state.bodies.size()) {
        for (std::uint32_t i = 0; i < state.bodies.size(); ++i) {
            const Body& body = state.bodies[i];
            if (!body.is_active) continue;
            bodies_[i] = {&shape_of(*body.shape, outputs, count, running), &body.frame};
            running.statistics.triangles += bodies_[i].shape->inputs.mesh->count;
            if (bodies_[i].shape->has_film) with_films_.push_back(i);
        }
    }

    scenes::SearchedScene scene() const { return {bodies_, *tree_, with_films_}; }

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

    std::shared_ptr<const scenes::BodyTree> tree_;
    std::vector<scenes::SearchedBody> bodies_;
    std::vector<std::uint32_t> with_films_;
    std::unordered_map<const Shape*, scenes::SearchedShape> shapes_;
};

Scene::Scene(Device device, const SceneOptions& options)
    : state_(std::make_unique<State>(std::move(device), options)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

Scene::State& Scene::state() const {
    return held_by(state_, "Scene");
}

std::uint32_t Scene::add(const Mesh& mesh, const Pose& pose, SignRule sign, const CallOptions& call) {
    return with_host_memory("for the body", [&] { return state().add(mesh, pose, sign, call); });
}

std::uint32_t Scene::add(const MeshView& mesh, const Pose& pose, SignRule sign, const CallOptions& call) {
    return with_host_memory("for the body", [&] { return state().add(mesh, pose, sign, call); });
}

std::uint32_t Scene::add_instance(std::uint32_t of, const Pose& pose) {
    return with_host_memory("for the body", [&] {
        State& state = this->state();
        Shape& shape = *state.body(of).shape;
        return state.add_body(pose, [&]() -> Shape& { return shape; });
    });
}

void Scene::set_poses(std::span<const Pose> poses) {
    with_host_memory("for the poses", [&] {
        State& state = this->state();
        if (poses.size() != state.bodies.size())
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("there are {} poses and {} bodies; give as many, or name the bodies", poses.size(),
                                    state.bodies.size()));
        std::vector<scenes::Frame> frames(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i) frames[i] = frame_of(poses[i], i);
        for (std::size_t i = 0; i < poses.size(); ++i) state.bodies[i].frame = frames[i];
        state.tree.reset();
    });
}

void Scene::set_poses(std::span<const std::uint32_t> bodies, std::span<const Pose> poses) {
    with_host_memory("for the poses", [&] {
        State& state = this->state();
        if (poses.size() != bodies.size())
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("{} bodies are named and there are {} poses; give as many", bodies.size(), poses.size()));
        std::vector<std::uint32_t> sorted(bodies.begin(), bodies.end());
        std::ranges::sort(sorted);
        if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
            throw Error(ErrorCode::invalid_argument, fmt::format("body {} is named twice; give it one pose", *twice));
        std::vector<scenes::Frame> frames(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i) {
            state.body(bodies[i]);
            frames[i] = frame_of(poses[i], bodies[i]);
        }
        for (std::size_t i = 0; i < poses.size(); ++i) state.bodies[bodies[i]].frame = frames[i];
        state.tree.reset();
    });
}

void Scene::set_positions(std::uint32_t body, const InputArray& positions, const CallOptions& call) {
    State& state = this->state();
    Shape& shape = *state.body(body).shape;
    shape.transform.set_positions(positions, call);
    shape.box = shape.transform.box();
    state.tree.reset();
}

void Scene::set_active(std::uint32_t body, bool is_active) {
    State& state = this->state();
    state.body(body).is_active = is_active;
    state.tree.reset();
}

std::size_t Scene::size() const {
    return state().bodies.size();
}

bool Scene::is_active(std::uint32_t body) const {
    return std::as_const(state()).body(body).is_active;
}

Pose Scene::pose(std::uint32_t body) const {
    const scenes::Frame& frame = std::as_const(state()).body(body).frame;
    return {frame.rotation, frame.translation};
}

SignRule Scene::sign(std::uint32_t body) const {
    return std::as_const(state()).body(body).shape->transform.sign();
}

bool Scene::has_sign() const {
    return std::ranges::any_of(state().bodies, [](const Body& body) {
        return body.is_active && body.shape->transform.sign() != SignRule::none;
    });
}

KeptMemory Scene::memory() const {
    KeptMemory sum;
    for (const Shape& shape : state().shapes) {
        const KeptMemory kept = shape.transform.memory();
        sum.host_bytes += kept.host_bytes;
        sum.device_bytes += kept.device_bytes;
        sum.shared_host_bytes = kept.shared_host_bytes;
        sum.shared_device_bytes = kept.shared_device_bytes;
    }
    return sum;
}

namespace {

void check_length(std::size_t length, std::size_t count, const char* name, bool may_be_empty) {
    if (length == count || (may_be_empty && length == 0)) return;
    throw Error(ErrorCode::invalid_argument,
                fmt::format("the array {} has {} items for {} points; give as many", name, length, count));
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
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("the array of the output {} has the strides ({}, {}, {}); points lie in one "
                                        "row: set strides[0] alone",
                                        info_of(output).name, array.strides[0], array.strides[1], array.strides[2]));
        memory_.add_triples(points, "points");
        targets::add_targets(targets, results, memory_);
        memory_.map(call.wait_list);
        positions_.emplace(memory_.mapped(points));
        targets_.emplace(targets::on_host(targets, results, memory_), targets::row_of(results), "there are {} points");
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

/// Computes results batch after batch: answer(begin, count, arrays) into packed arrays.
template <typename Answer>
scenes::UnusableOfScene in_batches(const targets::HostTargets& targets, std::size_t all, calls::RunningCall& running,
                                   const Answer& answer) {
    constexpr std::size_t most = std::size_t{1} << 14;
    scenes::UnusableOfScene unusable;
    targets::OwnArrays own;
    for (std::size_t begin = 0, count = 0; begin < all; begin += count) {
        running.throw_if_stopped();
        running.report({.fraction = static_cast<double>(begin) / static_cast<double>(all)});
        count = std::min(most, all - begin);
        const targets::HostArrays arrays =
            targets.are_packed ? targets::arrays_from(begin, targets.arrays) : own.for_samples(targets.arrays, count);
        const scenes::UnusableOfScene found = answer(begin, count, arrays);
        if (found.count > 0 && unusable.count == 0) {
            unusable.first = begin + found.first;
            unusable.is_finite = found.is_finite;
        }
        unusable.count += found.count;
        if (!targets.are_packed) targets.store(targets::row_of(count, begin), arrays);
    }
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
        State& state = this->state();
        state.require_bodies();
        points::check_half_width(half_width);
        half_width = std::abs(half_width);
        check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
        check_length(targets.bodies.size(), points.count, "bodies", true);
        check_length(targets.is_own.size(), points.count, "is_own", true);
        calls::RunningCall running{call};
        if (points.count == 0) return running.finish().published();
        std::vector<targets::WrittenArray> own;
        add_written(targets.bodies, "the array bodies", own);
        add_written(targets.is_own, "the array is_own", own);
        PointsOfCall arrays(state.context(), points, targets.outputs, points.count, std::move(own), call);
        const std::span<const Vec3> all = arrays.points();
        const State::Call searched(state, targets::outputs_of(targets.outputs), all.size(), running);
        const scenes::UnusableOfScene unusable = in_batches(
            arrays.results(), all.size(), running,
            [&](std::size_t begin, std::size_t count, const targets::HostArrays& to) {
                scenes::SceneArrays results{to};
                if (!targets.bodies.empty()) results.bodies = targets.bodies.data() + begin;
                if (!targets.is_own.empty()) results.is_own = targets.is_own.data() + begin;
                return scenes::answer_points(searched.scene(), all.subspan(begin, count), half_width, results);
            });
        const std::string warning = warning_of(unusable, all.size(), "point", all[unusable.first], call);
        running.statistics.unusable_points = unusable.count;
        arrays.unmap();
        if (call.log && !warning.empty()) call.log(warning);
        return running.finish().published();
    });
}

TransformStatistics Scene::query_pairs(const InputArray& points, std::span<const PointOfBody> pairs, double half_width,
                                       const OutputTargets& targets, const CallOptions& call) const {
    return with_host_memory("for the pairs; give fewer at once", [&] {
        State& state = this->state();
        state.require_bodies();
        points::check_half_width(half_width);
        half_width = std::abs(half_width);
        check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
        std::vector<scenes::Asked> asked(pairs.size());
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const auto [point, body] = pairs[i];
            if (point >= points.count)
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("pair {} names point {}, and there are {}", i, point, points.count));
            if (body >= state.bodies.size() || !state.bodies[body].is_active)
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("pair {} names body {}, which {}", i, body,
                                        body < state.bodies.size()
                                            ? std::string("is switched off")
                                            : fmt::format("is not there: the scene has {}", state.bodies.size())));
            asked[i] = {point, body};
        }
        calls::RunningCall running{call};
        if (pairs.empty()) return running.finish().published();
        PointsOfCall arrays(state.context(), points, targets, pairs.size(), {}, call);
        const std::span<const Vec3> all = arrays.points();
        const State::Call searched(state, targets::outputs_of(targets), pairs.size(), running);
        const scenes::UnusableOfScene unusable =
            in_batches(arrays.results(), pairs.size(), running,
                       [&](std::size_t begin, std::size_t count, const targets::HostArrays& to) {
                           return scenes::answer_pairs(searched.scene(), all, std::span(asked).subspan(begin, count),
                                                       half_width, to);
                       });
        const std::string warning = warning_of(unusable, pairs.size(), "pair", all[pairs[unusable.first].point], call);
        running.statistics.unusable_points = unusable.count;
        arrays.unmap();
        if (call.log && !warning.empty()) call.log(warning);
        return running.finish().published();
    });
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
        scenes::SceneArrays results;
        results.is_inside = is_inside.data();
        scenes::answer_points(searched.scene(), positions.get(), 0, results);
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
        for (const Body& body : state.bodies) {
            if (!body.is_active) continue;
            std::ranges::transform(all, in_body.begin(), [&](const Vec3& p) { return body.frame.to_body(p); });
            body.shape->transform.winding(in_body, of_body, {.should_stop = call.should_stop});
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
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("{} boxes have {} places for their answers; give as many", boxes.size(), places.size()));
        points::check_boxes(boxes);
        std::ranges::fill(places, has_sign() ? BoxPlace::outside : BoxPlace::beyond);
        std::vector<Box> in_body;
        std::vector<std::size_t> numbers;
        std::vector<BoxPlace> of_body;
        for (const Body& body : state.bodies) {
            if (!body.is_active) continue;
            in_body.clear();
            numbers.clear();
            for (std::size_t i = 0; i < boxes.size(); ++i) {
                if (places[i] == BoxPlace::inside) continue;
                const bool is_moved = body.frame.is_turned || body.frame.translation != Vec3{};
                in_body.push_back(is_moved ? body.frame.to_body(boxes[i]) : boxes[i]);
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

#include <clsdf/scene.hpp>

#include "calls/scenes/scene_state.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <list>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace clsdf {

scenes::Frame frame_of(const Pose& pose, const std::string& owner) {
    for (const double t : pose.translation)
        if (!std::isfinite(t))
            refuse("the translation{} is ({}, {}, {}), and must be finite", owner, pose.translation[0],
                   pose.translation[1], pose.translation[2]);
    const std::optional<scenes::Rotation> rotation = scenes::nearest_rotation(pose.rotation);
    if (!rotation)
        refuse(
            "the matrix{} is no rotation to 1e-5, or is a reflection; its rows must be unit "
            "vectors at right angles, and its determinant 1",
            owner);
    scenes::Frame frame{*rotation, pose.translation};
    frame.is_turned = frame.rotation != scenes::Frame().rotation;
    return frame;
}

namespace {

std::string of_body(std::size_t body) {
    return fmt::format(" of body {}", body);
}

void refuse_below(SignRule sign) {
    if (sign == SignRule::below)
        refuse_unsupported(
            "the sign rule below has walls along z, which do not turn with a body of a scene; close_down() "
            "makes a closed mesh");
}

void refuse_more_than_numbers(std::size_t bodies) {
    if (bodies > no_body) refuse_unsupported("a scene has at most {} bodies", no_body);
}

}  // namespace

Pose pose_of(std::span<const double, 16> matrix) {
    const std::span last = matrix.last<4>();
    if (last[0] != 0 || last[1] != 0 || last[2] != 0 || last[3] != 1)
        refuse(
            "the last row of the 4 x 4 matrix is {}, {}, {}, {}, and must be 0, 0, 0, 1; give the "
            "matrix by rows",
            last[0], last[1], last[2], last[3]);
    Pose pose;
    for (std::size_t row = 0; row < 3; ++row) {
        std::copy_n(matrix.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, pose.rotation[row].begin());
        pose.translation[row] = matrix[4 * row + 3];
    }
    const scenes::Frame frame = frame_of(pose, {});
    return {frame.rotation, frame.translation};
}

scenes::BodyTree Scene::State::tree_at(std::span<const scenes::Frame> frames) const {
    std::vector<Box> boxes;
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < bodies.size(); ++i)
        if (bodies[i].is_active) {
            boxes.push_back(frames[i].to_scene(bodies[i].shape->box));
            numbers.push_back(i);
        }
    return {boxes, numbers};
}

std::shared_ptr<const scenes::BodyTree> Scene::State::current_tree() {
    const std::scoped_lock lock(mutex);
    if (tree) return tree;
    std::vector<scenes::Frame> frames;
    for (const Body& body : bodies) frames.push_back(body.frame);
    return tree = std::make_shared<const scenes::BodyTree>(tree_at(frames));
}

template <typename MeshOrView>
Scene::State::Shape Scene::State::make_shape(const MeshOrView& mesh, SignRule sign, const CallOptions& call) const {
    DistanceTransform transform(device, mesh,
                                {.sign = sign, .kept_bytes = options.kept_bytes, .surface = options.surface}, call);
    const Box box = transform.box();
    return {std::move(transform), box, sign};
}

template <typename MeshOrView>
std::uint32_t Scene::State::add(const MeshOrView& mesh, const Pose& pose, SignRule sign, const CallOptions& call) {
    refuse_below(sign);
    return add_body(pose, [&]() -> Shape& { return shapes.emplace_back(make_shape(mesh, sign, call)); });
}

namespace {

/// The same options for calls of several threads.
CallOptions one_at_a_time(const CallOptions& call, std::mutex& mutex) {
    CallOptions options;
    const auto guarded = [&mutex](const auto& function) {
        return [&mutex, &function](const auto&... arguments) {
            const std::scoped_lock lock(mutex);
            return function(arguments...);
        };
    };
    if (call.should_stop) options.should_stop = guarded(call.should_stop);
    if (call.progress) options.progress = guarded(call.progress);
    if (call.log) options.log = guarded(call.log);
    return options;
}

}  // namespace

std::uint32_t Scene::State::add(std::span<const Mesh> meshes, std::span<const Pose> poses, SignRule sign,
                                const CallOptions& call) {
    refuse_below(sign);
    if (!poses.empty() && poses.size() != meshes.size())
        refuse("there are {} poses and {} meshes; give as many, or none", poses.size(), meshes.size());
    refuse_more_than_numbers(bodies.size() + meshes.size());
    const auto first = static_cast<std::uint32_t>(bodies.size());
    std::vector<scenes::Frame> frames(meshes.size());
    for (std::size_t i = 0; i < poses.size(); ++i) frames[i] = frame_of(poses[i], of_body(first + i));
    std::mutex of_call;
    const CallOptions options_of_mesh = one_at_a_time(call, of_call);
    std::vector<std::list<Shape>> made(meshes.size());
    for_each_index(
        meshes.size(), [&](std::size_t i) { made[i].push_back(make_shape(meshes[i], sign, options_of_mesh)); }, 1);
    bodies.reserve(std::max(2 * bodies.size(), bodies.size() + meshes.size()));  // so that nothing fails below
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        shapes.splice(shapes.end(), made[i]);
        bodies.push_back({&shapes.back(), frames[i], true});
    }
    forget_poses();
    return first;
}

template <typename MakeShape>
std::uint32_t Scene::State::add_body(const Pose& pose, const MakeShape& make_shape) {
    refuse_more_than_numbers(bodies.size() + 1);
    const scenes::Frame frame = frame_of(pose, of_body(bodies.size()));
    if (bodies.size() == bodies.capacity()) bodies.reserve(2 * bodies.size() + 1);  // so that nothing fails below
    bodies.push_back({&make_shape(), frame, true});
    forget_poses();
    return static_cast<std::uint32_t>(bodies.size() - 1);
}

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

std::uint32_t Scene::add(std::span<const Mesh> meshes, std::span<const Pose> poses, SignRule sign,
                         const CallOptions& call) {
    return with_host_memory("for the bodies", [&] { return state().add(meshes, poses, sign, call); });
}

std::uint32_t Scene::add_instance(std::uint32_t of, const Pose& pose) {
    return with_host_memory("for the body", [&] {
        State& state = this->state();
        State::Shape& shape = *state.body(of).shape;
        return state.add_body(pose, [&]() -> State::Shape& { return shape; });
    });
}

void Scene::set_poses(std::span<const Pose> poses) {
    with_host_memory("for the poses", [&] {
        State& state = this->state();
        if (poses.size() != state.bodies.size())
            refuse("there are {} poses and {} bodies; give as many, or name the bodies", poses.size(),
                   state.bodies.size());
        std::vector<scenes::Frame> frames(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i) frames[i] = frame_of(poses[i], of_body(i));
        for (std::size_t i = 0; i < poses.size(); ++i) state.bodies[i].frame = frames[i];
        state.forget_poses();
    });
}

void Scene::set_poses(std::span<const std::uint32_t> bodies, std::span<const Pose> poses) {
    with_host_memory("for the poses", [&] {
        State& state = this->state();
        if (poses.size() != bodies.size())
            refuse("{} bodies are named and there are {} poses; give as many", bodies.size(), poses.size());
        std::vector<std::uint32_t> sorted(bodies.begin(), bodies.end());
        std::ranges::sort(sorted);
        if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
            refuse("body {} is named twice; give it one pose", *twice);
        std::vector<scenes::Frame> frames(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i) {
            state.body(bodies[i]);
            frames[i] = frame_of(poses[i], of_body(bodies[i]));
        }
        for (std::size_t i = 0; i < poses.size(); ++i) state.bodies[bodies[i]].frame = frames[i];
        state.forget_poses();
    });
}

void Scene::set_positions(std::uint32_t body, const InputArray& positions, const CallOptions& call) {
    State& state = this->state();
    State::Shape& shape = *state.body(body).shape;
    shape.transform.set_positions(positions, call);
    shape.box = shape.transform.box();
    shape.moved_to.reset();
    if (state.joined) state.joined->frames.clear();
    state.forget_poses();
}

void Scene::set_active(std::uint32_t body, bool is_active) {
    State& state = this->state();
    state.body(body).is_active = is_active;
    state.forget_poses();
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

SignRule Scene::sign() const {
    return state().field_sign();
}

Box Scene::box() const {
    return with_host_memory("for the positions", [&] { return state().box(); });
}

bool Scene::has_sign() const {
    return state().has_sign();
}

KeptMemory Scene::memory() const {
    KeptMemory sum;
    const auto add = [&](const DistanceTransform& transform) {
        const KeptMemory kept = transform.memory();
        sum.host_bytes += kept.host_bytes;
        sum.device_bytes += kept.device_bytes;
        sum.shared_host_bytes = kept.shared_host_bytes;
        sum.shared_device_bytes = kept.shared_device_bytes;
    };
    State& state = this->state();
    const std::scoped_lock lock(state.field_mutex);
    for (const State::Shape& shape : state.shapes) {
        add(shape.transform);
        if (shape.moved) add(*shape.moved);
    }
    if (state.joined) add(state.joined->transform);
    if (state.cut_union) {
        add(state.cut_union->transform);
        sum.host_bytes += (state.cut_union->bodies.size() + state.cut_union->faces.size()) * sizeof(std::uint32_t);
    }
    const std::scoped_lock lock_of_lines(state.mutex);
    if (state.meeting_lines) sum.host_bytes += state.meeting_lines->host_bytes();
    return sum;
}

}  // namespace clsdf

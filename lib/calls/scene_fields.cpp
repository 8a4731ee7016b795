#include <clsdf/scene.hpp>

#include "calls/call.hpp"
#include "calls/scene_state.hpp"
#include "calls/transform_access.hpp"
#include "calls/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/vertices.hpp"
#include "plan/slabs.hpp"
#include "scenes/least_field.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/output_targets.hpp"
#include "targets/target_overlap.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// Packed arrays as the targets of a call.
OutputTargets targets_of(const targets::HostArrays& arrays, std::size_t samples) {
    OutputTargets result;
    for_each_output(
        [&](const OutputInfo& info, const targets::HostArray& array) {
            if (array.data == nullptr) return;
            OutputArray& target = result[info.output];
            target.host = array.data;
            target.bytes = samples * sample_bytes(info, array.in_double);
            target.type = array.in_double ? ElementType::float64 : info.type;
        },
        arrays);
    return result;
}

/// The bodies are looked up in the band that their own transform would be given.
Band band_of_body(Band band, SignRule sign) {
    if (sign == SignRule::none) band.has_exact_signs = false;
    return band;
}

void add_statistics(CallStatistics& sum, const CallStatistics& body) {
    const std::size_t triangles = sum.triangles + body.triangles, polyhedra = sum.polyhedra + body.polyhedra;
    add_call(sum, body);
    sum.triangles = triangles;
    sum.polyhedra = polyhedra;
}

/// Arrays of the library's own, into which the device writes on a processor: they stay if it is lost.
class PartArrays {
public:
    explicit PartArrays(const device::Context& context) : context_(context) {}
    PartArrays(const PartArrays&) = delete;
    PartArrays& operator=(const PartArrays&) = delete;
    ~PartArrays() {
        if (context_.is_lost()) keep_for_good(arrays_);
    }

    targets::HostArrays for_samples(const targets::HostArrays& wanted, std::size_t samples) {
        return arrays_.for_samples(wanted, samples);
    }
    std::size_t bytes() const { return arrays_.bytes(); }

private:
    const device::Context& context_;
    targets::OwnArrays arrays_;
};

}  // namespace

SignRule Scene::State::field_sign() const {
    std::optional<SignRule> sign;
    for (const Body& body : bodies) {
        const SignRule rule = body.shape->transform.sign();
        if (!body.is_active || rule == SignRule::none) continue;
        sign = !sign || *sign == rule ? rule : SignRule::nonzero;
    }
    return sign.value_or(SignRule::none);
}

namespace {

/// The positions that a transform of the body has.
std::vector<Vec3> moved_by(const scenes::Frame& frame, const Mesh& mesh) {
    return engine::Vertices::moved(mesh.vertices(), frame.rotation, frame.translation);
}

}  // namespace

Box Scene::State::box() {
    require_bodies();
    Box result = empty_box;
    for (const Body& body : bodies) {
        if (!body.is_active) continue;
        if (!is_moved(body.frame)) {
            clsdf::add(result, body.shape->box);
            continue;
        }
        auto& state = detail::TransformAccess::state(body.shape->transform);
        const std::scoped_lock lock(state.mutex);
        const Mesh& mesh = state.kept_mesh->mesh();
        const std::vector<Vec3> positions = moved_by(body.frame, mesh);
        for (const Triangle& triangle : mesh.triangles())
            for (const std::uint32_t vertex : triangle) clsdf::add(result, {positions[vertex], positions[vertex]});
    }
    return result;
}

const DistanceTransform& Scene::State::placed(const Body& body) {
    Shape& shape = *body.shape;
    const scenes::Frame& frame = body.frame;
    if (!is_moved(frame)) return shape.transform;
    if (shape.moved_to == frame) return *shape.moved;
    auto& state = detail::TransformAccess::state(shape.transform);
    std::vector<Vec3> positions;
    {
        const std::scoped_lock lock(state.mutex);
        const Mesh& present = state.kept_mesh->mesh();
        positions = moved_by(frame, present);
        if (!shape.moved) {
            Mesh first = present;
            first.set_positions(state.kept_mesh->first_positions());
            shape.moved.emplace(device, first, TransformOptions{.sign = shape.asked, .kept_bytes = options.kept_bytes});
        }
    }
    shape.moved_to.reset();
    shape.moved->set_positions(positions);
    shape.moved_to = frame;
    return *shape.moved;
}

CallStatistics Scene::State::compute(const Request& request, const CallOptions& call) {
    require_bodies();
    if (is_union())
        throw Error(
            ErrorCode::unsupported,
            "a scene whose surface is outer has no fields, which need cut faces; make a transform of the mesh of "
            "Scene::outer(), and anew when bodies have moved");
    const auto& [grid, band, given] = request;
    grid.validate();
    band.validate();
    engine::check_grid(grid);
    const std::size_t samples = grid.sample_count();
    if ((band.has_signs_only || band.has_exact_signs) && !has_sign())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} asked for, and no body of the scene has a sign; {}",
                                band.has_signs_only ? "a field of signs alone is" : "exact signs are",
                                band.has_signs_only ? "give the band a width" : "leave exact signs out"));
    targets::MappedMemory memory(context());
    targets::add_targets(given, grid, memory);
    memory.map(call.wait_list);
    const targets::HostTargets targets(targets::on_host(given, grid, memory), grid);
    std::vector<targets::WrittenArray> written;
    targets.add_written(0, written);
    targets::refuse_overlap(written);

    calls::RunningCall running{call};
    running.throw_if_stopped();
    const std::scoped_lock lock(field_mutex);
    std::vector<FieldPart> parts;
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
        const Body& body = bodies[i];
        const auto& state = detail::TransformAccess::state(body.shape->transform);
        if (!body.is_active || (band.has_signs_only && state.sign == SignRule::none)) continue;
        // Points outside the box of an open mesh may be inside.
        const bool has_film = state.sign == SignRule::solid_angle && !state.topology.balanced;
        const double margin =
            has_film ? std::numeric_limits<double>::infinity() : band.outside + state.kept_mesh->sign_surface_gap();
        if (const auto part = scenes::part_near(grid, body.frame.to_scene(body.shape->box), margin))
            parts.push_back({i, *part});
    }
    std::vector<FieldStep> steps = steps_of(parts, request);
    // A body that has most of the grid is computed in place, in all of it.
    const auto largest = std::ranges::max_element(steps, {}, [](const FieldStep& step) {
        return step.parts.size() == 1 ? step.parts.front().grid.sample_count() : 0;
    });
    const bool has_whole =
        largest != steps.end() && largest->parts.size() == 1 && largest->sample_count() >= samples / 2;
    if (has_whole) {
        largest->block = largest->parts.front().grid = grid;
        std::rotate(steps.begin(), largest, largest + 1);
    }

    targets::HostArrays wanted = targets.arrays, arrays;
    bool has_extras = false;
    for (const OutputInfo& info : extra_outputs()) has_extras = has_extras || wanted[info.output].is_wanted;
    wanted[Output::body].is_wanted = has_extras;
    PartArrays own(context()), own_bodies(context()), of_block(context());
    if (targets.are_packed) {
        arrays = targets.arrays;
        if (has_extras && arrays[Output::body].data == nullptr) {
            targets::HostArrays only;
            only[Output::body].is_wanted = true;
            arrays[Output::body] = own_bodies.for_samples(only, samples)[Output::body];
        }
    } else {
        arrays = own.for_samples(wanted, samples);
    }
    scenes::LeastField least(grid, arrays);
    if (!has_whole) least.clear(band.outside);

    double all = 0, done = 0;
    std::shared_ptr<const FieldStep::Members> counted;
    for (const FieldStep& step : steps) all += static_cast<double>(step.sample_count());
    for (const FieldStep& step : steps) {
        running.throw_if_stopped();
        const bool is_in_place = has_whole && done == 0;
        const std::size_t count = step.block.sample_count();
        const targets::HostArrays values = is_in_place ? arrays : of_block.for_samples(wanted, count);
        const DistanceTransform& transform = step.members ? joined_at(step) : placed(bodies[step.parts.front().body]);
        const Request asked{step.block, band_of_body(band, transform.sign()), targets_of(values, count)};
        std::vector<Grid> parts_of_step;
        if (step.members)
            for (const FieldPart& part : step.parts) parts_of_step.push_back(part.grid);
        const double next = done + static_cast<double>(step.sample_count()) / all;
        CallOptions of_step = calls::part_of(call, done, next);
        of_step.wait_list = {};
        CallStatistics made =
            detail::TransformAccess::state(transform).compute_on_host(std::span(&asked, 1), of_step, parts_of_step);
        if (step.members && step.members == counted) made.triangles = made.polyhedra = 0;
        counted = step.members;
        add_statistics(running.statistics, made);
        if (is_in_place)
            least.begin_with(step.parts.front().body);
        else  // parts of a step have no sample in common
            for_each_index(
                step.parts.size(),
                [&](std::size_t i) { least.add(step.parts[i].grid, step.block, values, step.parts[i].body); }, 1);
        done = next;
    }
    running.statistics.host_bytes += own.bytes() + own_bodies.bytes() + of_block.bytes();
    if (!targets.are_packed) targets.store(grid, arrays);
    memory.unmap();
    return running.finish();
}

TransformStatistics Scene::compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                   const CallOptions& call) const {
    return with_host_memory("for the field; compute a part of the grid", [&] {
        return state().compute({grid, band, targets}, call).published();
    });
}

Field Scene::compute(const Grid& grid, const Band& band, OutputSet outputs, const CallOptions& call,
                     TransformStatistics* statistics) const {
    State& state = this->state();
    Field field({.grid = grid, .band = band, .sign = state.field_sign(), .mesh_name = "scene"},
                targets::extras_of(outputs) | Output::distance);
    try {
        const TransformStatistics made = compute(grid, band, field.targets(), call);
        if (statistics != nullptr) *statistics = made;
    } catch (...) {
        if (state.context().is_lost()) keep_for_good(field);
        throw;
    }
    return field;
}

}  // namespace clsdf

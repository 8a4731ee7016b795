#include <clsdf/scene.hpp>

#include "calls/call.hpp"
#include "calls/scenes/scene_state.hpp"
#include "calls/transform/transform_access.hpp"
#include "calls/transform/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
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

const Mesh* Scene::State::mesh_if_moved(const Body& body) const {
    if (!is_moved(body.frame)) return nullptr;
    auto& state = detail::TransformAccess::state(body.shape->transform);
    const std::scoped_lock lock(state.mutex);
    return &state.kept_mesh->mesh();
}

namespace {

Box box_of(const Mesh& mesh, const scenes::Frame& frame) {
    Box result = empty_box;
    const std::vector<Vec3> positions = moved_by(frame, mesh);
    for (const Triangle& triangle : mesh.triangles())
        for (const std::uint32_t vertex : triangle) clsdf::add(result, {positions[vertex], positions[vertex]});
    return result;
}

}  // namespace

Box Scene::State::box() {
    require_bodies();
    Box result = empty_box;
    for (const Body& body : bodies) {
        if (!body.is_active) continue;
        const Mesh* const moved = mesh_if_moved(body);
        clsdf::add(result, moved == nullptr ? body.shape->box : box_of(*moved, body.frame));
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
    const auto& [grid, band, given] = request;
    grid.validate();
    band.validate();
    engine::check_grid(grid);
    const std::size_t samples = grid.sample_count();
    if ((band.has_signs_only || band.has_exact_signs) && !has_sign())
        refuse("{} asked for, and no body of the scene has a sign; {}",
               band.has_signs_only ? "a field of signs alone is" : "exact signs are",
               band.has_signs_only ? "give the band a width" : "leave exact signs out");
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
    targets::HostArrays wanted = targets.arrays, arrays;
    bool has_extras = false;
    for (const OutputInfo& info : extra_outputs()) has_extras = has_extras || wanted[info.output].is_wanted;
    targets::HostArrays needed;
    needed[Output::body].is_wanted = has_extras;
    needed[Output::triangle].is_wanted = has_extras && is_union();
    PartArrays own(context()), own_needed(context());
    for (const Output output : {Output::body, Output::triangle})
        wanted[output].is_wanted = wanted[output].is_wanted || needed[output].is_wanted;
    if (targets.are_packed) {
        arrays = targets.arrays;
        for (const Output output : {Output::body, Output::triangle})
            if (arrays[output].data != nullptr) needed[output].is_wanted = false;
        const targets::HostArrays added = own_needed.for_samples(needed, samples);
        for (const Output output : {Output::body, Output::triangle})
            if (needed[output].is_wanted) arrays[output] = added[output];
    } else {
        arrays = own.for_samples(wanted, samples);
    }
    if (is_union())
        compute_union(request, arrays, call, running);
    else
        compute_least(request, wanted, arrays, call, running);
    running.statistics.host_bytes += own.bytes() + own_needed.bytes();
    if (!targets.are_packed) targets.store(grid, arrays);
    memory.unmap();
    return running.finish();
}

std::vector<Scene::State::FieldPart> Scene::State::parts_of(const Grid& grid, const Band& band) const {
    /// A body with more faces is not moved for its box alone.
    constexpr std::size_t most_faces_for_box = 4096;
    struct Reached {
        std::uint32_t body;
        const Mesh* moved;  ///< null: the box follows from that of the mesh
        double gap;
    };
    std::vector<Reached> reached;
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
        const auto& state = detail::TransformAccess::state(bodies[i].shape->transform);
        if (!bodies[i].is_active || (band.has_signs_only && state.sign == SignRule::none)) continue;
        const bool is_small = state.kept_mesh->face_count() <= most_faces_for_box;
        // Points outside the box of an open mesh may be inside.
        const bool has_film = state.sign == SignRule::solid_angle && !state.topology.balanced;
        reached.push_back({i, is_small ? mesh_if_moved(bodies[i]) : nullptr,
                           has_film ? infinite_length : state.kept_mesh->sign_surface_gap()});
    }
    std::vector<std::optional<FieldPart>> found(reached.size());
    constexpr std::size_t grain = 16;
    for_each_index(
        reached.size(),
        [&](std::size_t i) {
            const auto& [number, moved, gap] = reached[i];
            const Body& body = bodies[number];
            const Box box = moved != nullptr ? box_of(*moved, body.frame) : body.frame.to_scene(body.shape->box);
            const auto part = scenes::part_near(grid, box, band.outside + gap),
                       near = scenes::part_near(grid, box, std::max(band.outside, band.inside) + gap);
            if (part && near) found[i] = FieldPart{number, *part, *near};
        },
        grain);
    std::vector<FieldPart> parts;
    for (const std::optional<FieldPart>& part : found)
        if (part) parts.push_back(*part);
    return parts;
}

void Scene::State::compute_least(const Request& request, const targets::HostArrays& wanted,
                                 const targets::HostArrays& arrays, const CallOptions& call,
                                 calls::RunningCall& running) {
    const Grid& grid = request.grid;
    const Band& band = request.band;
    std::vector<FieldStep> steps = steps_of(parts_of(grid, band), request);
    // A body that has most of the grid is computed in place, in all of it.
    const auto largest = std::ranges::max_element(steps, {}, [](const FieldStep& step) {
        return step.parts.size() == 1 ? step.parts.front().grid.sample_count() : 0;
    });
    const bool has_whole =
        largest != steps.end() && largest->parts.size() == 1 && largest->sample_count() >= grid.sample_count() / 2;
    if (has_whole) {
        largest->block = largest->parts.front().grid = grid;
        std::rotate(steps.begin(), largest, largest + 1);
    }

    PartArrays of_block(context());
    scenes::LeastField least(grid, arrays);
    if (!has_whole) least.clear(band.outside);

    double all = 0, done = 0;
    std::int64_t first_unwritten = grid.first[2];  // no step has written to slices from here on
    std::shared_ptr<const FieldStep::Members> counted;
    for (const FieldStep& step : steps) all += static_cast<double>(step.sample_count());
    for (const FieldStep& step : steps) {
        running.throw_if_stopped();
        // The first bodies of each block, too: elsewhere in it they leave the samples beyond the band.
        const bool is_in_place =
            has_whole ? done == 0 : step.members != nullptr && step.block.first[2] >= first_unwritten;
        const std::size_t count = step.block.sample_count();
        const targets::HostArrays values =
            is_in_place ? targets::arrays_from(grid.offset(0, 0, step.block.first[2] - grid.first[2]), arrays)
                        : of_block.for_samples(wanted, count);
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
        // Parts of a step have no sample in common.
        for_each_index(
            step.parts.size(),
            [&](std::size_t i) {
                const FieldPart& part = step.parts[i];
                if (is_in_place)
                    least.begin_with(part.grid, part.body);
                else
                    least.add(part.grid, step.block, values, part.body);
            },
            1);
        first_unwritten = std::max(first_unwritten, step.block.first[2] + step.block.size[2]);
        done = next;
    }
    running.statistics.host_bytes += of_block.bytes();
}

void Scene::State::compute_union(const Request& request, const targets::HostArrays& arrays, const CallOptions& call,
                                 calls::RunningCall& running) {
    for (const Output output : {Output::site, Output::barycentric})
        if (arrays[output].data != nullptr)
            refuse_unsupported(
                "{} of a field of a scene whose surface is outer is not known; leave it out, or look "
                "points up",
                info_of(output).name);
    if (!cut_union) {
        SceneSurface surface = outer(call);
        cut_union = CutUnion{std::move(surface.bodies), std::move(surface.surface.faces),
                             DistanceTransform(device, surface.surface.mesh,
                                               {.sign = SignRule::nonzero, .kept_bytes = options.kept_bytes},
                                               {.should_stop = call.should_stop})};
    }
    const std::size_t samples = request.grid.sample_count();
    const Request asked{request.grid, request.band, targets_of(arrays, samples)};
    CallOptions of_surface = call;
    of_surface.wait_list = {};
    add_statistics(
        running.statistics,
        detail::TransformAccess::state(cut_union->transform).compute_on_host(std::span(&asked, 1), of_surface));
    if (arrays[Output::triangle].data == nullptr) return;
    auto* const triangles = reinterpret_cast<std::uint32_t*>(arrays[Output::triangle].data);
    auto* const numbers = reinterpret_cast<std::uint32_t*>(arrays[Output::body].data);
    for_each_index(samples, [&](std::size_t i) {
        const std::uint32_t triangle = triangles[i];
        numbers[i] = triangle == no_triangle ? no_body : cut_union->bodies[triangle];
        if (triangle != no_triangle) triangles[i] = cut_union->faces[triangle];
    });
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

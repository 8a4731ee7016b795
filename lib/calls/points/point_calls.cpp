#include "calls/transform/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "device/in_flight.hpp"
#include "points/box_places.hpp"
#include "points/device_points.hpp"
#include "points/face_sides.hpp"
#include "points/few_points.hpp"
#include "points/packed_outputs.hpp"
#include "points/point_query.hpp"
#include "points/signs_by_host.hpp"
#include "points/usable_points.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/output_targets.hpp"
#include "targets/target_layout.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <utility>

namespace clsdf {

points::PointInputs DistanceTransform::State::point_inputs(OutputSet outputs, std::size_t count, bool on_host) {
    return calls::with_remedies(nullptr, {forgetting(), without_tables()}, [&] {
        points::PointInputs inputs;
        if (on_host)
            inputs.mesh = inputs.on_host = kept_points->mesh();
        else
            inputs.mesh = kept_points->faces();
        inputs.host_mesh = [this] { return kept_points->mesh(); };
        inputs.host_tree = [this] { return kept_points->wide_tree(); };
        const bool is_by_group = programs.body == KernelBody::by_group && !on_host;
        if (is_by_group) {
            inputs.triangles = kept_points->triangles();
            inputs.tree = kept_points->fitted_tree();
            inputs.sign_faces = kept_points->sign_faces(sign);
        }
        const bool has_room = !on_host && !points_are_short_of_memory;
        const bool are_many = has_room && !kept_points->has_borrowed_leaves() &&
                              points::is_scan_worthwhile(programs, count, kept_mesh->face_count());
        if (are_many)
            inputs.scanned = kept_points->scanned_mesh();
        else if (!is_by_group)
            inputs.leaves = kept_points->wide_leaves();
        if (sign != SignRule::none && !on_host)
            inputs.sides = kept_points->face_sides(
                sign, has_room && points::are_sides_worthwhile(points_asked, kept_mesh->face_count()));
        const NormalsNeeded normals = normals_for(outputs);
        inputs.sites = kept_points->sites(outputs, normals.are_needed, inputs.sides.get());
        inputs.sign = sign;
        inputs.is_inside_out = normals.is_inside_out;
        if (!on_host) return inputs;
        // Only what these outputs need.
        engine::DeviceSites sites = *inputs.sites;
        if (!engine::names_sites(outputs)) sites.names.reset();
        if (!normals.are_needed) {
            sites.normals.reset();
            sites.turned = 0;
        }
        inputs.sites = std::make_shared<const engine::DeviceSites>(std::move(sites));
        points::bring_to_host(inputs);
        return inputs;
    });
}

points::PointInputs DistanceTransform::State::inputs_of_many(OutputSet outputs, std::size_t count,
                                                             calls::RunningCall& running) {
    points::PointInputs inputs = point_inputs(outputs, count, false);
    if (inputs.needs_deep_stack())
        test(checks::point_subject(device, programs, checks::PointKernels::of_deep_trees), running);
    return inputs;
}

void DistanceTransform::State::find_usable(points::UsablePoints& asked, const Box& box, double half_width) const {
    asked.find(box);
    // Points before the first usable one have copies of it.
    if (const auto* restriction = kept_mesh->restriction())
        restriction->check(asked.points().subspan(asked.first_usable()), half_width, asked.first_usable());
}

DistanceTransform::State::WindingInputs DistanceTransform::State::winding_inputs() {
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    context().begin_call();
    const bool is_closed = topology.balanced && sign != SignRule::none;
    const bool is_known = is_closed || sign == SignRule::solid_angle || sign == SignRule::below;
    if (kept_mesh->restriction() != nullptr && !is_known)
        throw Error(ErrorCode::unsupported,
                    fmt::format("the transform is restricted, has the sign rule {} and does not keep what winding "
                                "numbers need; restrict one with the sign rule solid-angle",
                                name_of(sign)));
    WindingInputs inputs;
    calls::with_remedies(nullptr, {forgetting()}, [&] {
        inputs.mesh = kept_points->mesh();
        inputs.tree = kept_points->wide_tree();
    });
    inputs.boundary = is_known ? kept_mesh->boundary() : kept_mesh->any_boundary();
    if (!inputs.boundary) inputs.boundary = std::make_shared<const OpenBoundary>();
    return inputs;
}

points::PointInputs DistanceTransform::State::inputs_of_few(OutputSet outputs, std::size_t count,
                                                            calls::RunningCall& running,
                                                            const std::function<void(const Box&)>& check) {
    mutex.check_thread();
    context().require_usable();
    if (std::optional<points::PointInputs> inputs = kept_points->inputs_of_few(outputs)) {
        check(inputs->mesh->box);
        return std::move(*inputs);
    }
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    check(kept_mesh->box());  // before anything is made
    context().begin_call();
    pool->restart_peak();
    const Stopwatch watch;
    points::PointInputs inputs = point_inputs(outputs, count, true);
    kept_points->remember(inputs, outputs);
    // A scene asks for several meshes in one call.
    running.statistics.polyhedra_seconds += watch.seconds();
    pool->trim();
    running.statistics.device_bytes += pool->peak();
    return inputs;
}

CallStatistics DistanceTransform::State::query_few(points::UsablePoints& asked, double half_width, OutputSet outputs,
                                                   const targets::HostTargets& targets, const CallOptions& call) {
    calls::RunningCall running{call};
    CallStatistics& statistics = running.statistics;
    const points::PointInputs inputs = inputs_of_few(outputs, asked.points().size(), running, [&](const Box& box) {
        running.throw_if_stopped();
        find_usable(asked, box, half_width);
    });
    const std::span<const Vec3> all = asked.points();
    statistics.triangles = inputs.mesh->count;
    statistics.device_bytes =
        std::max(statistics.device_bytes, inputs.mesh->device_bytes() + inputs.leaves->device_bytes());
    targets::OwnArrays own;
    const bool in_place = targets.are_packed;
    const targets::HostArrays arrays = in_place ? targets.arrays : own.for_samples(targets.arrays, all.size());
    const points::PointTimes times = points::answer_points(inputs, all, half_width, arrays);
    asked.store(0, all.size(), half_width, arrays);
    if (!in_place) targets.store(targets::row_of(all.size()), arrays);
    statistics.field_seconds = times.nearest;
    statistics.sign_seconds = times.sign;
    return running.finish();
}

CallStatistics DistanceTransform::State::query_many(points::UsablePoints& asked, double half_width, OutputSet outputs,
                                                    const targets::HostTargets& targets, const CallOptions& call) {
    const KeepsBudget keeps_budget(*this);
    calls::RunningCall running{call};
    CallStatistics& statistics = running.statistics;
    statistics.triangles = kept_mesh->face_count();
    {
        const std::scoped_lock lock(mutex);
        context().begin_call();
        running.throw_if_stopped();
        find_usable(asked, kept_mesh->box(), half_width);  // before anything is made
        test(checks::point_subject(device, programs, checks::PointKernels::of_all), running);
        if (points::is_scan_worthwhile(programs, asked.points().size(), kept_mesh->face_count()))
            test(checks::point_subject(device, programs, checks::PointKernels::of_many), running);
        pool->restart_peak();
        const Stopwatch watch;
        points_asked += asked.points().size();
        inputs_of_many(outputs, asked.points().size(), running);  // what it makes is kept
        statistics.polyhedra_seconds = watch.seconds();
    }
    const std::span<const Vec3> all = asked.points();
    device::InFlight<targets::OwnArrays> own(context());
    own.begin();
    std::size_t most = points::most_points;
    const auto share = [&](std::size_t points) {
        return static_cast<double>(points) / static_cast<double>(all.size());
    };
    for (std::size_t begin = 0, count = 0; begin < all.size(); begin += count) {
        targets::HostArrays arrays;
        const auto answer = [&] {
            count = most = std::min(most, all.size() - begin);
            arrays = targets.are_packed ? targets::arrays_from(begin, targets.arrays)
                                        : own->for_samples(targets.arrays, count);
            return points::query_points(tools(), inputs_of_many(outputs, all.size(), running),
                                        all.subspan(begin, count), half_width, arrays,
                                        running.between(share(begin), share(begin + count)));
        };
        {
            const std::scoped_lock lock(mutex);
            const auto times = calls::with_remedies(&running, remedies_for_points(most), answer);
            statistics.sign_seconds += times.sign;
            statistics.field_seconds += times.nearest;
        }
        asked.store(begin, count, half_width, arrays);
        if (!targets.are_packed) targets.store(targets::row_of(count, begin), arrays);
    }
    own.end();
    {
        const std::scoped_lock lock(mutex);
        pool->trim();
        statistics.device_bytes = pool->peak();
    }
    return running.finish();  // which calls the caller's function
}

std::vector<calls::Remedy> DistanceTransform::State::remedies_for_points(std::size_t& most) {
    const auto fewer_than = [&most](std::size_t least) {
        return calls::Remedy{[&most, least] {
                                 if (most <= least) return false;
                                 most /= 2;
                                 return true;
                             },
                             true};
    };
    return {forgetting(), fewer_than(std::size_t{1} << 15), without_tables(), fewer_than(256)};
}

bool DistanceTransform::State::stay_on_device(const InputArray& points, const OutputTargets& targets) const {
    if (programs.body != KernelBody::by_group || context().capabilities().is_processor || points.device == nullptr ||
        points.count <= points::most_few_points || points.count >= std::numeric_limits<cl_uint>::max() ||
        kept_mesh->restriction() != nullptr ||
        !std::ranges::all_of(targets.all(), [](const OutputTarget& target) { return target.array.device != nullptr; }))
        return false;
    const auto is_allowed = [](cl_mem memory, cl_mem_flags forbidding) {
        return (cl::Buffer(memory, true).getInfo<CL_MEM_FLAGS>() & forbidding) == 0;
    };
    return device::guarded([&] {
        if (!is_allowed(points.device, CL_MEM_WRITE_ONLY) ||
            !std::ranges::all_of(targets.all(), [&](const OutputTarget& target) {
                return is_allowed(target.array.device, CL_MEM_READ_ONLY);
            }))
            return false;
        const targets::DeviceTargets on_device(targets::targets_from(targets, 0), targets::row_of(points.count),
                                               context());
        std::vector<targets::WrittenArray> written;
        on_device.add_written(0, written);
        targets::refuse_overlap(written);
        points::check_device_points(context(), points);
        // The outputs of some points may lie on others: then the points are copied first.
        written.push_back(points::array_of(points));
        return !targets::find_overlap(written);
    });
}

namespace {

void refuse_unusable(const std::array<points::UnusablePoints, 2>& unusable, const points::UsableRange& range) {
    for (const points::UnusablePoints& of_kind : unusable) {
        const points::UnusablePoints& other = unusable[of_kind.are_finite ? 0 : 1];
        if (of_kind.count > 0 && (other.count == 0 || of_kind.first < other.first))
            points::refuse_unusable(of_kind, range);
    }
}

}  // namespace

CallStatistics DistanceTransform::State::query_on_device(const InputArray& points, double half_width, OutputSet outputs,
                                                         const OutputTargets& targets, const CallOptions& call,
                                                         std::string& warning) {
    const KeepsBudget keeps_budget(*this);
    calls::RunningCall running{call};
    CallStatistics& statistics = running.statistics;
    statistics.triangles = kept_mesh->face_count();
    const points::DevicePoints asked = points::points_in(points);
    const points::UsableRange range = points::usable_range(kept_mesh->box());
    const PointLimits usable = points::limits_of(range.limits);
    {
        const std::scoped_lock lock(mutex);
        context().begin_call();
        running.throw_if_stopped();
        test(checks::point_subject(device, programs, checks::PointKernels::of_all), running);
        pool->restart_peak();
        const Stopwatch watch;
        points_asked += asked.count;
        const auto inputs = [&] { return inputs_of_many(outputs, asked.count, running); };
        inputs();  // what it makes is kept
        statistics.polyhedra_seconds = watch.seconds();
        std::size_t most = std::min(points::most_points, asked.count);
        const std::vector<calls::Remedy> remedies = remedies_for_points(most);
        const auto share = [&](std::size_t number) {
            return static_cast<double>(number) / static_cast<double>(asked.count);
        };
        std::optional<points::PointRun> run;
        points::PackedOutputs packed;
        PointCells found{};
        bool are_measured = false;
        for (std::size_t begin = 0, count = 0; begin < asked.count; begin += count) {
            const auto times = calls::with_remedies(&running, remedies, [&] {
                if (!run || run->most() > most) {
                    run.reset();
                    are_measured = false;
                    run.emplace(tools(), most);
                }
                if (!are_measured && call.refuse_unusable_points) {  // before anything is written
                    found = points::measured_points(tools(), *run, asked, usable, *inputs().mesh);
                    refuse_unusable(points::unusable_points(tools(), asked, found), range);
                    are_measured = true;
                }
                count = std::min(run->most(), asked.count - begin);
                const auto of_part = device::guarded([&] {
                    return targets::DeviceTargets(targets::targets_from(targets, begin), targets::row_of(count),
                                                  context());
                });
                packed.make_room(*pool, of_part, count);
                const points::PointTimes taken = points::query_points(
                    tools(), inputs(), *run, {asked.part(begin, count), usable, are_measured ? nullptr : &asked},
                    half_width, packed.buffers_for(of_part),
                    [&](const engine::Launches& launches) { packed.enqueue_copies(launches, tools(), of_part, count); },
                    found, running.between(share(begin), share(begin + count)));
                are_measured = true;
                return taken;
            });
            statistics.sign_seconds += times.sign;
            statistics.field_seconds += times.nearest;
        }
        const std::array<points::UnusablePoints, 2> unusable = points::unusable_points(tools(), asked, found);
        for (const points::UnusablePoints& of_kind : unusable) statistics.unusable_points += of_kind.count;
        warning = points::warning_of(unusable, asked.count, range, half_width);
        pool->trim();
        statistics.device_bytes = pool->peak();
    }
    return running.finish();  // which calls the caller's function
}

TransformStatistics DistanceTransform::query(const InputArray& points, double half_width, const OutputTargets& targets,
                                             const CallOptions& call) const {
    return with_host_memory("for the points; give fewer at once", [&] {
        State& state = this->state();
        points::check_half_width(half_width);
        check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
        if (points.count == 0) {  // vectors without elements have no memory
            calls::RunningCall{call}.report({.fraction = 1});
            return CallStatistics().published();
        }
        for (const auto& [output, array] : targets.all())
            if (array.strides[1] != 0 || array.strides[2] != 0)
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("the array of the output {} has the strides ({}, {}, {}); points lie in one "
                                        "row: set strides[0] alone",
                                        info_of(output).name, array.strides[0], array.strides[1], array.strides[2]));
        targets::MappedMemory memory(device::context_of(state.device));
        memory.add_triples(points, "points");
        targets::add_targets(targets, targets::row_of(points.count), memory);
        if (state.stay_on_device(points, targets)) {
            targets::wait_for(device::context_of(state.device), call.wait_list);
            std::string warning;
            const CallStatistics statistics = state.query_on_device(
                points, std::abs(half_width), targets::outputs_of(targets), targets, call, warning);
            if (call.log && !warning.empty()) call.log(warning);
            return statistics.published();
        }
        memory.map(call.wait_list);
        const PositionArray positions(memory.mapped(points));
        const targets::HostTargets on_host(targets::on_host(targets, targets::row_of(points.count), memory),
                                           targets::row_of(points.count), "there are {} points");
        std::vector<targets::WrittenArray> written;
        on_host.add_written(0, written);
        targets::refuse_overlap(written);
        // The outputs of some points may lie on others.
        std::vector<Vec3> copy;
        written.push_back({.first = reinterpret_cast<std::uintptr_t>(positions.get().data()),
                           .width = positions.get().size_bytes(),
                           .name = "the points"});
        if (targets::find_overlap(written)) copy.assign(positions.get().begin(), positions.get().end());
        const std::span<const Vec3> all = copy.empty() ? positions.get() : copy;
        const auto answer = all.size() <= points::most_few_points ? &State::query_few : &State::query_many;
        points::UsablePoints asked(all, call.refuse_unusable_points);
        CallStatistics statistics =
            (state.*answer)(asked, std::abs(half_width), targets::outputs_of(targets), on_host, call);
        statistics.unusable_points = asked.unusable();
        const std::string warning = asked.warning(std::abs(half_width));
        memory.unmap();
        if (call.log && !warning.empty()) call.log(warning);
        return statistics.published();
    });
}

void DistanceTransform::winding(const InputArray& points, const OutputArray& results, const CallOptions& call) const {
    with_host_memory("for the points; give fewer at once", [&] {
        State& state = this->state();
        check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
        if (points.count == 0) return;
        targets::MappedMemory memory(device::context_of(state.device));
        memory.add_triples(points, "points");
        const OutputTargets targets(results);  // winding numbers have the type and the place of distances
        const auto placed = [&](const auto& place) {
            try {
                return place();
            } catch (const Error& error) {
                throw Error(error.code(), fmt::format("winding numbers are written as distances are: {}", error.what()),
                            error.opencl_code());
            }
        };
        placed([&] { targets::add_targets(targets, targets::row_of(points.count), memory); });
        memory.map(call.wait_list);
        const PositionArray positions(memory.mapped(points));
        const targets::HostTargets on_host = placed([&] {
            return targets::HostTargets(targets::on_host(targets, targets::row_of(points.count), memory),
                                        targets::row_of(points.count), "there are {} points");
        });
        if (const auto* restriction = state.kept_mesh->restriction()) restriction->check(positions.get(), 0);
        const auto [mesh, tree, boundary] = state.winding_inputs();
        UninitializedVector<double> numbers(points.count);
        const double farthest = 1e14 * mesh->lattice.unit;  // beyond, what rounding leaves of it is 0
        calls::RunningCall running{call};
        const std::function<void(double)> between = running.between(0, 1);
        // A point of a mesh with ten thousand open edges takes a third of a millisecond.
        constexpr std::size_t grain = 16, least_batch = 512, largest_batch = 4096;
        const std::size_t batch = std::clamp(points.count / 1000, least_batch, largest_batch);
        for (std::size_t first = 0; first < points.count; first += batch) {
            if (between) between(static_cast<double>(first) / static_cast<double>(points.count));
            for_each_index(
                std::min(batch, points.count - first),
                [&](std::size_t n) {
                    const std::size_t i = first + n;
                    const Vec3& point = positions.get()[i];
                    bool is_finite = true, is_near = true;
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        is_finite = is_finite && std::isfinite(point[axis]);
                        is_near = is_near && point[axis] > mesh->box.lower[axis] - farthest &&
                                  point[axis] < mesh->box.upper[axis] + farthest;
                    }
                    numbers[i] = !is_finite ? std::numeric_limits<double>::quiet_NaN()
                                 : is_near  ? points::winding_number({*mesh, *tree}, *boundary, point)
                                            : 0;
                },
                grain);
        }
        if (between) between(1);
        const OutputArray& target = on_host.targets[Output::distance];
        std::byte* to = static_cast<std::byte*>(target.host) + target.offset;
        for (std::size_t i = 0; i < points.count; ++i, to += target.strides[0]) {
            const auto single = static_cast<float>(numbers[i]);
            if (targets::is_in_double(target))
                std::memcpy(to, &numbers[i], sizeof numbers[i]);
            else
                std::memcpy(to, &single, sizeof single);
        }
        memory.unmap();
    });
}

void DistanceTransform::classify(std::span<const Box> boxes, double half_width, std::span<BoxPlace> places) const {
    with_host_memory("for the boxes; give fewer at once", [&] {
        State& state = this->state();
        if (!(half_width >= 0))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the half width around boxes is {}, and must be 0 or more", half_width));
        if (places.size() != boxes.size())
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("{} boxes have {} places for their answers; give as many", boxes.size(), places.size()));
        points::check_boxes(boxes);
        if (const auto* restriction = state.kept_mesh->restriction()) restriction->check(boxes, half_width);
        const auto [mesh, tree] = [&] {
            const State::KeepsBudget keeps_budget(state);
            const std::scoped_lock lock(state.mutex);
            state.context().begin_call();
            return calls::with_remedies(nullptr, {state.forgetting()}, [&] {
                return std::pair(state.kept_points->mesh(), state.kept_points->wide_tree());
            });
        }();
        points::find_places({*mesh, *tree}, state.sign, boxes, half_width, places);
    });
}

}  // namespace clsdf

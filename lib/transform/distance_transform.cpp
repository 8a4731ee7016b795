#include <clsdf/distance_transform.hpp>

#include "core/lifetime.hpp"
#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "device/mapped_memory.hpp"
#include "scan/layout_of.hpp"
#include "scan/output_targets.hpp"
#include "scan/slabs.hpp"
#include "transform/transform_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace clsdf {

void DistanceTransform::State::compute(transform::PlanState& plan, const scan::SlabPipeline::Slot& slot, double begin,
                                       double end, const CallOptions& call) const {
    const Stopwatch watch;
    const device::Context& context = device::context_of(device);
    device::guarded([&] {
        std::function<void(double)> between;
        if (call.progress || call.should_stop)
            between = [&](double fraction) {
                transform::throw_if_stopped(call);
                if (call.progress) call.progress(begin + (end - begin) * fraction);
            };
        try {
            plan.enqueue(context.queue(), slot.buffers(), {}, between);
            slot.enqueue_handover(context.queue());
            context.queue().finish();
            plan.read_counters();
            plan.read_times(context.queue());
        } catch (...) {
            // Commands that are still running write to the caller's memory.
            context.drain();
            throw;
        }
    });
    plan.statistics.field_seconds = watch.seconds();
}

void DistanceTransform::State::compute(const Grid& grid, const Band& band, const Outputs& outputs,
                                       const scan::HostArrays& arrays, bool in_place, std::vector<Grid> slabs,
                                       std::span<const Grid> wanted, scan::SlabPipeline& pipeline,
                                       const CallOptions& call) {
    const KeepsBudget keeps_budget{*this};
    TransformStatistics statistics;
    transform::Compiling compiling(call, options.log);
    std::unique_ptr<transform::PlanState> plan;
    transform::Inputs inputs_of_grid;
    const auto set_inputs = [&] {
        const Stopwatch watch;
        inputs_of_grid = inputs(grid, band, outputs);
        statistics.polyhedra_seconds = watch.seconds();
        transform::throw_if_stopped(call);
    };
    {
        const std::scoped_lock lock(mutex);
        transform::throw_if_stopped(call);
        compile(grid, band, outputs, call.count, compiling);
        pool->restart_peak();
        if (slabs.size() == 1) plan = take_plan(grid, band, outputs, wanted, call.count);
        if (!plan) set_inputs();
    }
    const auto samples = static_cast<double>(grid.sample_count());
    bool has_room = false;  // a slab that cannot be divided was tried again without what is kept for later
    std::reverse(slabs.begin(), slabs.end());
    for (std::size_t done = 0; !slabs.empty();) {
        const Grid slab = slabs.back();
        slabs.pop_back();
        const std::size_t count = slab.sample_count();
        scan::SlabPipeline::Slot& slot = pipeline.next();
        try {
            const std::scoped_lock lock(mutex);
            if (in_place) {
                scan::HostArrays part;
                for_each_output([&](const OutputRow& row, const auto& array,
                                    auto& of_slab) { of_slab = array.from_sample(row, done); },
                                arrays, part);
                pipeline.place(slot, slab, part);
            } else {
                pipeline.place_own(slot, slab, arrays);
            }
            if (!plan) {
                // A part of the grid needs a part of what the grid needs.
                transform::Inputs inputs_of_slab = inputs_of_grid;
                if (count < grid.sample_count())
                    stages->select(slab, scan::layout_of(slab, band, sign), inputs_of_slab);
                plan = make_plan(std::move(inputs_of_slab), slab, band, outputs, wanted, call, compiling);
            }
            transform::throw_if_stopped(call);
            compute(*plan, slot, static_cast<double>(done) / samples, static_cast<double>(done + count) / samples,
                    call);
            transform::add_slab(statistics, plan->statistics);
            if (count < grid.sample_count()) plan.reset();
        } catch (const Error& error) {
            // How long a slab's lists are is known when they are made.
            const bool is_divisible = scan::is_divisible(slab);
            if (error.code() != ErrorCode::out_of_memory || (!is_divisible && has_room)) throw;
            const std::scoped_lock lock(mutex);
            if (is_divisible) {
                const auto [lower, upper] = scan::halves_of(slab);
                slabs.push_back(upper);
                slabs.push_back(lower);
            } else {
                has_room = true;
                slabs.push_back(slab);
            }
            // Commands that are still running use the buffers.
            device::guarded([&] { device::context_of(device).queue().finish(); });
            pipeline.take_back(slot);
            plan.reset();
            forget();
            if (!inputs_of_grid.records) set_inputs();
            continue;
        }
        pipeline.deliver(slot, slab);
        done += count;
    }
    pipeline.finish();
    {
        const std::scoped_lock lock(mutex);
        report(compiling, statistics);
        statistics.device_bytes = pool->peak();
        statistics.host_bytes = pipeline.host_bytes();
        inputs_of_grid = {};
        if (plan) keep(std::move(plan), call.count);
    }
    if (call.progress) call.progress(1.0);
    if (call.statistics != nullptr) *call.statistics = statistics;
}

DistanceTransform::DistanceTransform(Device device, const Mesh& mesh, TransformOptions options, const CallOptions& call)
    : state_(std::make_unique<State>(std::move(device), mesh, std::move(options), call)) {}
DistanceTransform::DistanceTransform(Device device, const MeshView& mesh, TransformOptions options,
                                     const CallOptions& call, std::span<const cl_event> wait_list) {
    device::MappedMemory memory(device::context_of(device));
    memory.add(mesh.vertices(), "vertices");
    memory.add(mesh.triangles(), "triangles");
    memory.map(wait_list);
    Mesh copy(MeshView(memory.on_host(mesh.vertices()), memory.on_host(mesh.triangles())));
    memory.unmap();
    state_ = std::make_unique<State>(std::move(device), std::move(copy), std::move(options), call);
}
DistanceTransform::DistanceTransform(DistanceTransform&&) noexcept = default;
DistanceTransform& DistanceTransform::operator=(DistanceTransform&&) noexcept = default;
DistanceTransform::~DistanceTransform() = default;

DistanceTransform::State& DistanceTransform::state() const {
    return held_by(state_, "DistanceTransform");
}

const Topology& DistanceTransform::topology() const {
    return state().topology;
}
SignRule DistanceTransform::sign() const {
    return state().sign;
}
DistanceTransform DistanceTransform::restrict_to(const Box& box, double half_width, double spacing) const {
    DistanceTransform part;
    part.state_ = state().restricted(box, half_width, spacing);
    return part;
}
void DistanceTransform::move(const Triples& positions, std::span<const cl_event> wait_list) {
    State& state = this->state();
    check_triples(positions, TripleKind::positions, "positions", ErrorCode::invalid_argument);
    device::MappedMemory memory(device::context_of(state.device));
    memory.add(positions, "positions");
    memory.map(wait_list);
    state.move(PositionArray(memory.on_host(positions)).get());
    memory.unmap();
}
void DistanceTransform::move(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    state().move(rotation, translation);
}

KeptMemory DistanceTransform::memory() const {
    State& state = this->state();
    const std::scoped_lock lock(state.mutex);
    KeptMemory memory{state.stages->host_bytes() + state.first_positions.size() * sizeof(Vec3),
                      state.stages->device_bytes()};
    for (const State::KeptPlan& kept : state.plans) memory.device_bytes += state.bytes_of(*kept.plan);
    return memory;
}

bool DistanceTransform::compile(const Grid& grid, const Band& band, const Outputs& outputs,
                                const CallOptions& call) const {
    State& state = this->state();
    transform::throw_if_stopped(call);
    const std::scoped_lock lock(state.mutex);
    transform::Compiling compiling(call, state.options.log);
    const bool is_tested = state.compile(grid, band, outputs, call.count, compiling);
    state.compile_seconds += compiling.seconds;
    state.first_use |= compiling.first_use;
    return is_tested;
}

void DistanceTransform::State::compute(const Grid& grid, const Band& band, const Outputs& outputs,
                                       const scan::HostTargets& targets, const CallOptions& call) {
    const device::Context& context = device::context_of(device);
    const bool in_place = targets.are_packed();
    const auto store = [&](const Grid& part, const scan::HostArrays& values) { targets.store(part, values); };
    const scan::SlabLimits limits =
        in_place ? scan::limits_of(context.capabilities()) : scan::stream_limits_of(context.capabilities());
    std::vector<Grid> slabs = scan::slabs_of(grid, limits);
    scan::SlabPipeline pipeline(context, pool, in_place ? scan::ArraySink() : scan::ArraySink(store), slabs.size() > 1);
    compute(grid, band, outputs, targets.arrays(), in_place, std::move(slabs), {}, pipeline, call);
}

void DistanceTransform::State::compute(const transform::Batch& batch, std::span<const Request> requests,
                                       std::span<const scan::HostTargets> targets, scan::SlabPipeline& pipeline,
                                       const CallOptions& call) {
    const std::size_t any = batch.requests.front();
    const Request& request = requests[any];
    const Outputs outputs = scan::outputs_of(request.targets);
    if (batch.requests.size() == 1) {
        compute(request.grid, request.band, outputs, targets[any], call);
        return;
    }
    const device::Context& context = device::context_of(device);
    std::vector<Grid> wanted;
    for (const std::size_t n : batch.requests) wanted.push_back(requests[n].grid);
    compute(batch.block, request.band, outputs, targets[any].arrays(), false,
            scan::slabs_of(batch.block, scan::stream_limits_of(context.capabilities())), wanted, pipeline, call);
}

void DistanceTransform::compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                const CallOptions& call) const {
    grid.validate();
    if (targets.distance.device != nullptr) {
        const Request request{grid, band, targets};
        compute_on_device({&request, 1}, call);
        return;
    }
    state().compute(grid, band, scan::outputs_of(targets), scan::HostTargets(targets, grid), call);
}

void DistanceTransform::compute(std::span<const Request> requests, const CallOptions& call) const {
    State& state = this->state();
    if (!requests.empty() && requests.front().targets.distance.device != nullptr) {
        compute_on_device(requests, call);
        return;
    }
    const std::vector<scan::HostTargets> targets = transform::targets_of(
        requests, [&](const Request& request) { state.stages->check(request.grid, request.band, state.sign); });
    std::vector<scan::HostArrays> arrays;
    for (const scan::HostTargets& target : targets) arrays.push_back(target.arrays());
    const std::vector<transform::Batch> batches = transform::batches_of(requests, arrays, state.mesh().box());
    double cost = 0, done = 0;
    for (const transform::Batch& batch : batches) cost += batch.cost;
    const device::Context& context = device::context_of(state.device);
    const transform::Batch* computed = nullptr;
    const auto store = [&](const Grid& part, const scan::HostArrays& values) {
        constexpr std::size_t chunk = 8;
        for_each_chunk(computed->requests.size(), chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) targets[computed->requests[n]].store(part, values);
        });
    };
    // On a processor the next slab would take the cores that store the one before.
    scan::SlabPipeline pipeline(context, state.pool, store, !context.capabilities().is_processor);
    TransformStatistics total;
    for (const transform::Batch& batch : batches) {
        computed = &batch;
        TransformStatistics statistics;
        CallOptions of_batch = call;
        of_batch.statistics = &statistics;
        if (call.progress)
            of_batch.progress = [&](double fraction) { call.progress((done + batch.cost * fraction) / cost); };
        state.compute(batch, requests, targets, pipeline, of_batch);
        transform::add_call(total, statistics);
        done += batch.cost;
    }
    if (call.statistics != nullptr) *call.statistics = total;
}

void DistanceTransform::compute_on_device(std::span<const Request> requests, const CallOptions& call) const {
    const device::Context& context = device::context_of(state().device);
    RequestPlan plan = this->plan(requests, call);
    device::guarded([&] {
        const Stopwatch watch;
        const cl::Event end(plan.enqueue(context.callers_queue()()));
        end.wait();
        if (call.statistics != nullptr) call.statistics->field_seconds = watch.seconds();
    });
    if (call.progress) call.progress(1.0);
}

void DistanceTransform::compute_slabs(const Grid& grid, const Band& band, const Outputs& outputs, const SlabSink& sink,
                                      const SlabOptions& options, const CallOptions& call) const {
    State& state = this->state();
    grid.validate();
    grid.sample_count();
    if (!sink) throw Error(ErrorCode::invalid_argument, "DistanceTransform::compute_slabs needs a sink; it is empty");
    const device::Context& context = device::context_of(state.device);
    const auto hand_on = [&](const Grid& part, const scan::HostArrays& values) {
        sink(part, scan::slab_of(values, part.sample_count()));
    };
    scan::SlabPipeline pipeline(context, state.pool, hand_on, options.overlap);
    state.compute(grid, band, outputs, scan::arrays_for(outputs), false,
                  scan::slabs_of(grid, scan::stream_limits_of(context.capabilities())), {}, pipeline, call);
}

std::vector<Grid> DistanceTransform::slabs_of(const Grid& grid) {
    grid.validate();
    device::Context::Capabilities unlimited;
    unlimited.memory = unlimited.largest_allocation = std::numeric_limits<std::size_t>::max();
    return scan::slabs_of(grid, scan::stream_limits_of(unlimited));
}

Field DistanceTransform::operator()(const Grid& grid, const Band& band, const Outputs& outputs,
                                    const CallOptions& call) const {
    Field field;
    field.grid = grid;
    field.band = band;
    field.sign = sign();
    field.mesh_name = state().mesh().name();
    grid.validate();
    OutputTargets targets;
    try {
        field.distance.resize(grid.sample_count());
        targets.distance = field.distance;
        for_each_extra(
            [&](const OutputRow& row, bool wanted, auto& array, OutputTarget& target) {
                if (!wanted) return;
                array.resize(grid.sample_count() * row.components);
                target = array;
            },
            outputs, field, targets);
    } catch (const std::exception&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("a field of {} x {} x {} samples does not fit the memory; compute parts of the grid",
                                grid.size[0], grid.size[1], grid.size[2]));
    }
    try {
        compute(grid, band, targets, call);
    } catch (const Error&) {
        if (device::context_of(state_->device).is_lost()) keep_for_good(field);
        throw;
    }
    return field;
}

}  // namespace clsdf

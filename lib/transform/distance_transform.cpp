#include <clsdf/distance_transform.hpp>

#include "core/large_memory.hpp"
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

DistanceTransform::DistanceTransform(Device device, const Mesh& mesh, TransformOptions options, const CallOptions& call)
    : state_(with_host_memory(
          "for the mesh", [&] { return std::make_unique<State>(std::move(device), mesh, std::move(options), call); })) {
}
DistanceTransform::DistanceTransform(Device device, const MeshView& mesh, TransformOptions options,
                                     const CallOptions& call, std::span<const cl_event> wait_list) {
    with_host_memory("for the mesh", [&] {
        device::MappedMemory memory(device::context_of(device));
        memory.add(mesh.vertices(), "vertices");
        memory.add(mesh.triangles(), "triangles");
        memory.map(wait_list);
        Mesh copy(MeshView(memory.on_host(mesh.vertices()), memory.on_host(mesh.triangles())));
        memory.unmap();
        state_ = std::make_unique<State>(std::move(device), std::move(copy), std::move(options), call);
    });
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
    return with_host_memory("to restrict the transform", [&] {
        DistanceTransform part;
        part.state_ = state().restricted(box, half_width, spacing);
        return part;
    });
}
void DistanceTransform::move(const Triples& positions, std::span<const cl_event> wait_list) {
    with_host_memory("to move the vertices", [&] {
        State& state = this->state();
        check_triples(positions, TripleKind::positions, "positions", ErrorCode::invalid_argument);
        device::MappedMemory memory(device::context_of(state.device));
        memory.add(positions, "positions");
        memory.map(wait_list);
        const PositionArray array(memory.on_host(positions));
        std::vector<Vec3> copy;
        if (positions.device != nullptr) {
            copy.assign(array.get().begin(), array.get().end());
            memory.unmap();  // which may fail, before anything has moved
        }
        state.move(copy.empty() ? array.get() : copy);
    });
}
void DistanceTransform::move(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    with_host_memory("to move the vertices", [&] { state().move(rotation, translation); });
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
    return with_host_memory("to compile", [&] {
        State& state = this->state();
        transform::Caller caller(call);
        caller.throw_if_stopped();
        const std::scoped_lock lock(state.mutex);
        state.check(grid, band, outputs);
        transform::Compiling compiling(caller, state.options.log);
        const bool is_tested = state.compile(grid, band, outputs, call.count, compiling);
        state.compile_seconds += compiling.seconds;
        state.first_use |= compiling.first_use;
        return is_tested;
    });
}

void DistanceTransform::compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                const CallOptions& call, std::span<const cl_event> wait_list) const {
    with_host_memory("for the computation; compute less at once", [&] {
        grid.validate();
        if (targets.distance.device != nullptr) {
            const Request request{grid, band, targets};
            compute_on_device({&request, 1}, call, wait_list);
            return;
        }
        device::wait_for(device::context_of(state().device), wait_list);
        state().compute(grid, band, scan::outputs_of(targets), scan::HostTargets(targets, grid), call);
    });
}

void DistanceTransform::compute(std::span<const Request> requests, const CallOptions& call,
                                std::span<const cl_event> wait_list) const {
    with_host_memory("for the requests; give fewer at once", [&] {
        State& state = this->state();
        if (!requests.empty() && requests.front().targets.distance.device != nullptr) {
            compute_on_device(requests, call, wait_list);
            return;
        }
        device::wait_for(device::context_of(state.device), wait_list);
        const std::vector<scan::HostTargets> targets = transform::targets_of(requests, [&](const Request& request) {
            state.check(request.grid, request.band, scan::outputs_of(request.targets));
        });
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
    });
}

void DistanceTransform::compute_on_device(std::span<const Request> requests, const CallOptions& call,
                                          std::span<const cl_event> wait_list) const {
    const device::Context& context = device::context_of(state().device);
    CallOptions of_plan = call;
    of_plan.statistics = nullptr;  // not before the run has succeeded
    Plan plan(state().plan(true, {requests.begin(), requests.end()}, std::nullopt, of_plan, call.count));
    device::guarded([&] {
        const Stopwatch watch;
        const cl::Event end(plan.enqueue(context.callers_queue()(), wait_list));
        end.wait();
        device::wait_for(context, wait_list);  // Intel's runtime reports success
        if (call.count) plan.state().read_counters();
        if (call.statistics != nullptr) {
            *call.statistics = plan.statistics();
            call.statistics->field_seconds = watch.seconds();
        }
    });
    if (call.progress) call.progress(1.0);
}

void DistanceTransform::compute_slabs(const Grid& grid, const Band& band, const Outputs& outputs, const SlabSink& sink,
                                      const SlabOptions& options, const CallOptions& call) const {
    with_host_memory("for the slabs; compute a part of the grid", [&] {
        State& state = this->state();
        grid.validate();
        grid.sample_count();
        state.check(grid, band, outputs);
        if (!sink)
            throw Error(ErrorCode::invalid_argument, "DistanceTransform::compute_slabs needs a sink; it is empty");
        const device::Context& context = device::context_of(state.device);
        const auto hand_on = [&](const Grid& part, const scan::HostArrays& values) {
            sink(part, scan::slab_of(values, part.sample_count()));
        };
        scan::SlabPipeline pipeline(context, state.pool, hand_on, options.overlap);
        const scan::HostArrays arrays = scan::arrays_for(outputs);
        state.compute(grid, band, outputs, arrays, false,
                      scan::slabs_of(grid, scan::stream_limits_of(context.capabilities()), scan::widest_of(arrays)), {},
                      pipeline, call);
    });
}

std::vector<Grid> DistanceTransform::slabs_of(const Grid& grid) {
    grid.validate();
    device::Context::Capabilities unlimited;
    unlimited.memory = unlimited.largest_allocation = std::numeric_limits<std::size_t>::max();
    scan::layout_of(grid, {0, 0}, SignRule::none);  // which refuses grids that cannot be computed
    return with_host_memory("for the list of slabs",
                            [&] { return scan::slabs_of(grid, scan::stream_limits_of(unlimited)); });
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

#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/stopwatch.hpp"
#include "device/mapped_memory.hpp"
#include "scan/layout_of.hpp"
#include "scan/slabs.hpp"
#include "transform/stored_boxes.hpp"
#include "transform/transform_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace clsdf {

namespace transform {

namespace {

/// For the caller, who releases the event.
cl_event enqueue_run(RequestPlanState& state, cl_command_queue queue, std::span<const cl_event> wait_list,
                     const OutputBuffers* in_place) {
    const device::Context& context = device::context_of(state.device);
    const cl::Event last =
        state.enqueue(device::queue_of(context, queue), device::events_of(context, wait_list), in_place);
    clRetainEvent(last());
    return last();
}

/// The blocks by which batches are computed.
std::vector<RequestPlanState::Block> blocks_of(std::span<const Batch> batches,
                                               std::span<const scan::DeviceTargets> targets,
                                               const device::Context& context) {
    const std::size_t largest = context.capabilities().largest_allocation;
    std::vector<RequestPlanState::Block> blocks;
    for (const Batch& batch : batches) {
        const scan::DeviceTargets& any = targets[batch.requests.front()];
        const bool in_place = batch.requests.size() == 1 && any.in_place().has_value();
        const auto limits =
            in_place ? scan::SlabLimits{largest, largest, largest} : scan::stream_limits_of(context.capabilities());
        const std::vector<Grid> slabs = scan::slabs_of(batch.block, limits, scan::widest_of(any.arrays()));
        for (const Grid& slab : slabs) blocks.push_back({&batch, slab, in_place && slabs.size() == 1});
    }
    return blocks;
}

}  // namespace

}  // namespace transform

void DistanceTransform::State::plan(transform::RequestPlanState& made, std::vector<Request> requests,
                                    const CallOptions& call) {
    if (device::context_of(made.device).context()() != device::context_of(device).context()())
        throw Error(ErrorCode::invalid_argument,
                    "the transform has another device than the plan; move the plan with a transform of its Device");
    const std::vector<scan::DeviceTargets> targets = transform::device_targets_of(
        requests, device::context_of(device),
        [this](const Request& request) { stages->check(request.grid, request.band, sign); });
    std::swap(made.requests, requests);
    made.is_whole = false;
    try {
        plan(made, targets, call);
    } catch (...) {
        std::swap(made.requests, requests);
        made.clear();
        made.pool->release();
        throw;
    }
}

std::unique_ptr<transform::RequestPlanState> DistanceTransform::State::plan(
    const Request& request, const std::function<scan::DeviceTargets()>& targets_of, const CallOptions& call) {
    request.grid.validate();
    request.band.validate();
    stages->check(request.grid, request.band, sign);
    const scan::DeviceTargets targets = targets_of();
    auto made = std::make_unique<transform::RequestPlanState>(device, std::vector<Request>{request}, pool, false);
    plan(*made, {&targets, 1}, call);
    return made;
}

void DistanceTransform::State::plan(transform::RequestPlanState& made, std::span<const scan::DeviceTargets> targets,
                                    const CallOptions& call) {
    const std::span<const Request> requests = made.requests;
    const device::Context& context = device::context_of(device);
    std::vector<scan::HostArrays> arrays;
    for (const scan::DeviceTargets& target : targets) arrays.push_back(target.arrays());
    const std::vector<transform::Batch> batches = transform::batches_of(requests, arrays, mesh().box());
    const std::vector<transform::RequestPlanState::Block> blocks = transform::blocks_of(batches, targets, context);

    const KeepsBudget keeps_budget{*this};
    const std::scoped_lock lock(mutex);
    transform::throw_if_stopped(call);
    transform::Compiling compiling(call, options.log);
    if (!std::all_of(blocks.begin(), blocks.end(), [](const auto& block) { return block.in_place; })) {
        const Stopwatch compile_watch;
        compiling.first_use = transform::ensure_store_tested(device, programs, compiling.watch(1));
        compiling.seconds = compile_watch.seconds();
    }
    made.sign = sign;
    double polyhedra_seconds = 0;
    std::size_t bytes_of_inputs = 0;  // that the transform does not keep
    // An error of the caller's function is passed on, also if it is one of memory.
    std::exception_ptr of_caller;
    CallOptions watched = call;
    if (call.should_stop)
        watched.should_stop = [&] {
            try {
                return call.should_stop();
            } catch (...) {
                of_caller = std::current_exception();
                throw;
            }
        };
    bool is_retry = false;
    const auto make = [&] {
        if (of_caller) std::rethrow_exception(of_caller);
        made.clear();
        if (std::exchange(is_retry, true) && made.has_own_pool) made.pool->release();
        made.make_room(blocks, targets);
        polyhedra_seconds = 0;
        bytes_of_inputs = 0;
        transform::Inputs inputs_of_batch;
        const transform::Batch* batch = nullptr;
        for (const transform::RequestPlanState::Block& block : blocks) {
            const Request& any = requests[block.batch->requests.front()];
            const Outputs outputs = scan::outputs_of(targets[block.batch->requests.front()].arrays());
            if (block.batch != batch) {
                batch = block.batch;
                compile(batch->block, any.band, outputs, call.count, compiling);
                const Stopwatch watch;
                inputs_of_batch = inputs(batch->block, any.band, outputs, true);
                polyhedra_seconds += watch.seconds();
                bytes_of_inputs += stages->bytes_beside(inputs_of_batch);
            }
            std::vector<Grid> wanted;
            if (batch->requests.size() > 1)
                for (const std::size_t n : batch->requests) wanted.push_back(requests[n].grid);
            transform::Inputs inputs_of_block = inputs_of_batch;
            if (!(block.grid == batch->block))
                stages->select(block.grid, scan::layout_of(block.grid, any.band, sign), inputs_of_block);
            auto of_block = make_plan(std::move(inputs_of_block), block.grid, any.band, outputs, wanted, watched,
                                      compiling, made.pool);
            transform::add_slab(made.statistics, of_block->statistics);
            made.add(block, std::move(of_block), targets, programs);
        }
        return true;
    };
    make_room_for([&] { return device::guarded(make); });
    device::guarded([&] { context.queue().finish(); });  // errors of the set-up's commands are thrown here
    if (made.has_own_pool) made.pool->release();
    made.is_whole = true;
    made.statistics.polyhedra_seconds = polyhedra_seconds;
    made.statistics.device_bytes = made.own_bytes() + bytes_of_inputs;
    report(compiling, made.statistics);
    if (call.statistics != nullptr) *call.statistics = made.statistics;
}

Plan::Plan(std::unique_ptr<transform::RequestPlanState> state) : state_(std::move(state)) {}
Plan::Plan(Plan&&) noexcept = default;
Plan& Plan::operator=(Plan&&) noexcept = default;
Plan::~Plan() = default;

transform::RequestPlanState& Plan::state() const {
    return held_by(state_, "Plan");
}

const Grid& Plan::grid() const {
    return state().requests.front().grid;
}
const Band& Plan::band() const {
    return state().requests.front().band;
}
SignRule Plan::sign() const {
    return state().sign;
}
const TransformStatistics& Plan::statistics() const {
    return state().statistics;
}

cl_event Plan::enqueue(cl_command_queue queue, const OutputTargets& targets, std::span<const cl_event> wait_list) {
    transform::RequestPlanState& state = this->state();
    return device::guarded([&] {
        const scan::OutputBuffers in_place = state.set_targets(targets);
        return transform::enqueue_run(state, queue, wait_list, &in_place);
    });
}

RequestPlan::RequestPlan(std::unique_ptr<transform::RequestPlanState> state) : state_(std::move(state)) {}
RequestPlan::RequestPlan(RequestPlan&&) noexcept = default;
RequestPlan& RequestPlan::operator=(RequestPlan&&) noexcept = default;
RequestPlan::~RequestPlan() = default;

transform::RequestPlanState& RequestPlan::state() const {
    return held_by(state_, "RequestPlan");
}

std::span<const Request> RequestPlan::requests() const {
    return state().requests;
}

const TransformStatistics& RequestPlan::statistics() const {
    return state().statistics;
}

cl_event RequestPlan::enqueue(cl_command_queue queue, std::span<const cl_event> wait_list) {
    transform::RequestPlanState& state = this->state();
    if (!state.is_whole)
        throw Error(ErrorCode::invalid_argument,
                    "the plan's last move() failed, so that it has nothing to compute with; move it again, or make a "
                    "new plan");
    return device::guarded([&] { return transform::enqueue_run(state, queue, wait_list, nullptr); });
}

void RequestPlan::move(const DistanceTransform& transform, std::span<const Grid> grids, const CallOptions& call) {
    with_host_memory("for the plan; give fewer requests", [&] {
        transform::RequestPlanState& state = this->state();
        if (!grids.empty() && grids.size() != state.requests.size())
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("the plan has {} requests, and {} grids are given to move them to; give one for each, "
                            "or none",
                            state.requests.size(), grids.size()));
        std::vector<Request> requests = state.requests;
        for (std::size_t n = 0; n < grids.size(); ++n) requests[n].grid = grids[n];
        transform.state().plan(state, std::move(requests), call);
    });
}

void RequestPlan::replan(const DistanceTransform& transform, std::span<const Request> requests,
                         const CallOptions& call) {
    with_host_memory("for the plan; give fewer requests", [&] {
        transform.state().plan(state(), {requests.begin(), requests.end()}, call);
    });
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, const Outputs& outputs,
                             const CallOptions& call) const {
    return with_host_memory("for the plan", [&] {
        return Plan(state().plan(
            {grid, band, {}}, [&] { return scan::DeviceTargets(outputs, grid); }, call));
    });
}

Plan DistanceTransform::plan(const Request& request, const CallOptions& call) const {
    const auto targets = [&] {
        return device::guarded(
            [&] { return scan::DeviceTargets(request.targets, request.grid, device::context_of(state().device)); });
    };
    return with_host_memory("for the plan", [&] { return Plan(state().plan(request, targets, call)); });
}

RequestPlan DistanceTransform::plan(std::span<const Request> requests, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer requests", [&] {
        State& state = this->state();
        auto made = std::make_unique<transform::RequestPlanState>(state.device, std::vector<Request>(),
                                                                  state.pool->beside(), true);
        state.plan(*made, std::vector<Request>(requests.begin(), requests.end()), call);
        return RequestPlan(std::move(made));
    });
}

std::size_t DistanceTransform::plan_bytes(std::span<const Request> requests, const CallOptions& call) const {
    return plan(requests, call).statistics().device_bytes;
}

}  // namespace clsdf

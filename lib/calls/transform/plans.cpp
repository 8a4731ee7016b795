#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/stopwatch.hpp"
#include "plan/slabs.hpp"
#include "prepare/layout_of.hpp"
#include "targets/mapped_memory.hpp"
#include "transform/stored_boxes.hpp"
#include "transform/transform_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace clsdf {

namespace transform {

namespace {

/// done: for the caller, who releases it; may be null. targets: see PlanState::enqueue().
void enqueue_run(PlanState& state, cl_command_queue queue, std::span<const cl_event> wait_list, cl_event* done,
                 std::span<const DeviceTargets> targets) {
    const device::Context& context = device::context_of(state.device);
    const cl::Event last =
        state.enqueue(device::queue_of(context, queue), device::events_of(context, wait_list), targets);
    if (done == nullptr) return;
    clRetainEvent(last());
    *done = last();
}

void require_whole(const PlanState& state) {
    if (!state.is_whole)
        throw Error(ErrorCode::invalid_argument,
                    "the plan's last update failed, so that it has nothing to compute with; update it again");
}

/// The blocks by which batches are computed.
std::vector<PlanState::Block> blocks_of(std::span<const Batch> batches, std::span<const scan::DeviceTargets> targets,
                                        const device::Context& context) {
    const std::size_t largest = context.capabilities().largest_allocation;
    std::vector<PlanState::Block> blocks;
    for (const Batch& batch : batches) {
        const scan::DeviceTargets& any = targets[batch.requests.front()];
        const bool in_place = batch.requests.size() == 1 && any.in_place.has_value();
        const auto limits =
            in_place ? scan::SlabLimits{largest, largest, largest} : scan::stream_limits_of(context.capabilities());
        const std::vector<Grid> slabs = scan::slabs_of(batch.job.grid, limits, scan::widest_of(any.arrays));
        for (const Grid& slab : slabs) blocks.push_back({&batch, slab, in_place && slabs.size() == 1});
    }
    return blocks;
}

}  // namespace

}  // namespace transform

std::unique_ptr<Plan::State> DistanceTransform::State::plan(bool has_own_pool, std::vector<Request> requests,
                                                            std::optional<OutputSet> outputs_without_targets,
                                                            const CallOptions& call, bool counts) {
    auto made = std::make_unique<Plan::State>(device, has_own_pool ? pool->beside() : pool, has_own_pool);
    made->counts = counts;
    plan(*made, std::move(requests), outputs_without_targets, call);
    return made;
}

void DistanceTransform::State::plan(transform::PlanState& made, std::vector<Request> requests,
                                    std::optional<OutputSet> outputs_without_targets, const CallOptions& call) {
    const device::Context& context = device::context_of(device);
    if (&device::context_of(made.device) != &context)
        throw Error(ErrorCode::invalid_argument,
                    "the transform has another device than the plan; update the plan with a transform of its Device");
    const auto targets = transform::targets_of(
        requests, [&](const Request& request) { return device_targets(request, outputs_without_targets); });
    mutex.check_thread();
    made.clear();  // waits for its runs before the mutex is locked: other threads may use the transform
    std::swap(made.requests, requests);
    std::swap(made.outputs_without_targets, outputs_without_targets);
    try {
        plan(made, targets, call);
    } catch (...) {
        std::swap(made.requests, requests);
        std::swap(made.outputs_without_targets, outputs_without_targets);
        made.clear();
        if (made.has_own_pool) made.pool->release();
        throw;
    }
}

void DistanceTransform::State::plan(transform::PlanState& made, std::span<const scan::DeviceTargets> targets,
                                    const CallOptions& call) {
    const device::Context& context = device::context_of(device);
    std::vector<scan::HostArrays> arrays;
    for (const scan::DeviceTargets& target : targets) arrays.push_back(target.arrays);
    const std::vector<transform::Batch> batches =
        transform::batches_of(made.requests, arrays, stages->mesh().box(), made.counts);
    const std::vector<transform::PlanState::Block> blocks = transform::blocks_of(batches, targets, context);

    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    transform::Caller caller{call};
    caller.throw_if_stopped();
    transform::Compiling compiling(caller);
    if (!std::ranges::all_of(blocks, &transform::PlanState::Block::in_place))
        test(transform::stored_boxes_subject(device, programs), compiling);
    made.sign = sign;
    bool is_retry = false;
    const auto make = [&] {
        made.clear();
        if (std::exchange(is_retry, true) && made.has_own_pool) made.pool->release();
        try {
            made.make_room(blocks, targets);
            add_blocks(made, blocks, targets, caller, compiling);
        } catch (...) {
            context.drain();  // the set-up's commands use what is given back
            throw;
        }
    };
    transform::with_remedies(&caller, {forgetting()}, [&] { device::guarded(make); });
    device::guarded([&] { context.queue().finish(); });  // errors of the set-up's commands are thrown here
    if (made.has_own_pool) made.pool->release();
    made.is_whole = true;
    compiling.describe(made.statistics);
    made.published = made.statistics.published();
}

void DistanceTransform::State::add_blocks(transform::PlanState& made,
                                          std::span<const transform::PlanState::Block> blocks,
                                          std::span<const scan::DeviceTargets> targets, transform::Caller& caller,
                                          transform::Compiling& compiling) {
    transform::Inputs batch_inputs;
    const transform::Batch* batch = nullptr;
    for (const transform::PlanState::Block& block : blocks) {
        if (block.batch != batch) {
            batch = block.batch;
            compile(batch->job, compiling);
            const Stopwatch watch;
            batch_inputs = inputs(batch->job, true);
            made.statistics.polyhedra_seconds += watch.seconds();
        }
        transform::Inputs block_inputs = batch_inputs;
        if (!(block.grid == batch->job.grid))
            stages->select(block.grid, scan::layout_of(block.grid, batch->job.band, sign), block_inputs);
        auto block_plan = make_plan(with(made.pool), std::move(block_inputs), batch->job.part(block.grid), caller);
        add_slab(made.statistics, block_plan->statistics);
        made.add(block, std::move(block_plan), targets, programs);
    }
    keep_within_budget();
    made.statistics.device_bytes = made.own_bytes(*stages);
}

Plan::Plan(std::unique_ptr<State> state) : state_(std::move(state)) {}
Plan::Plan(Plan&&) noexcept = default;
Plan& Plan::operator=(Plan&&) noexcept = default;
Plan::~Plan() = default;

Plan::State& Plan::state() const {
    return held_by(state_, "Plan");
}

std::span<const Request> Plan::requests() const {
    return state().requests;
}

SignRule Plan::sign() const {
    return state().sign;
}

const TransformStatistics& Plan::statistics() const {
    return state().published;
}

void Plan::enqueue(cl_command_queue queue, std::span<const cl_event> wait_list, cl_event* done) {
    State& state = this->state();
    transform::require_whole(state);
    if (state.outputs_without_targets)
        throw Error(
            ErrorCode::invalid_argument,
            "the plan was made of a grid and has no targets; give this run targets, or make the plan of a request");
    with_host_memory("for a run of the plan",
                     [&] { device::guarded([&] { transform::enqueue_run(state, queue, wait_list, done, {}); }); });
}

void Plan::enqueue(cl_command_queue queue, std::span<const OutputTargets> targets, std::span<const cl_event> wait_list,
                   cl_event* done) {
    State& state = this->state();
    transform::require_whole(state);
    with_host_memory("for the targets of a run; give fewer", [&] {
        device::guarded([&] { transform::enqueue_run(state, queue, wait_list, done, state.targets_of(targets)); });
    });
}

void Plan::enqueue(cl_command_queue queue, const OutputTargets& targets, std::span<const cl_event> wait_list,
                   cl_event* done) {
    enqueue(queue, std::span(&targets, 1), wait_list, done);
}

void Plan::update(const DistanceTransform& transform, const CallOptions& call) {
    with_host_memory("for the plan", [&] {
        State& state = this->state();
        transform.state().plan(state, state.requests, state.outputs_without_targets, call);
    });
}

void Plan::update(const DistanceTransform& transform, std::span<const Grid> grids, const CallOptions& call) {
    with_host_memory("for the plan; give fewer requests", [&] {
        State& state = this->state();
        if (grids.size() != state.requests.size())
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the plan has {} requests, and {} grids are given; give one for each",
                                    state.requests.size(), grids.size()));
        std::vector<Request> requests = state.requests;
        for (std::size_t n = 0; n < grids.size(); ++n) requests[n].grid = grids[n];
        transform.state().plan(state, std::move(requests), state.outputs_without_targets, call);
    });
}

void Plan::update(const DistanceTransform& transform, std::span<const Request> requests, const CallOptions& call) {
    with_host_memory("for the plan; give fewer requests", [&] {
        transform.state().plan(state(), {requests.begin(), requests.end()}, std::nullopt, call);
    });
}

void Plan::update(const DistanceTransform& transform, const BlockSet& blocks, const CallOptions& call) {
    with_host_memory("for the plan; give fewer blocks",
                     [&] { update(transform, transform::requests_of(blocks, 0, blocks.first.size()), call); });
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, OutputSet outputs, const CallOptions& call) const {
    return with_host_memory("for the plan", [&] {
        return Plan(state().plan(false, std::vector<Request>{{grid, band, {}}}, scan::extras_of(outputs), call));
    });
}

Plan DistanceTransform::plan(std::span<const Request> requests, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer requests", [&] {
        return Plan(state().plan(requests.size() != 1, {requests.begin(), requests.end()}, std::nullopt, call));
    });
}

Plan DistanceTransform::plan(const BlockSet& blocks, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer blocks",
                            [&] { return plan(transform::requests_of(blocks, 0, blocks.first.size()), call); });
}

std::size_t DistanceTransform::plan_bytes(std::span<const Request> requests, const CallOptions& call) const {
    return plan(requests, call).statistics().device_bytes;
}

std::size_t DistanceTransform::plan_bytes(const BlockSet& blocks, const CallOptions& call) const {
    return plan(blocks, call).statistics().device_bytes;
}

}  // namespace clsdf

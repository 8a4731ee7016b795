#include "calls/slab_plans.hpp"
#include "calls/stored_boxes.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/stopwatch.hpp"
#include "targets/mapped_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace clsdf {

namespace calls {

namespace {

/// done: for the caller, who releases it; may be null. targets: see PlanState::enqueue().
void enqueue_run(PlanState& state, cl_command_queue queue, std::span<const cl_event> wait_list, cl_event* done,
                 std::span<const targets::DeviceTargets> targets) {
    const device::Context& context = device::context_of(state.device);
    const cl::Event last =
        state.enqueue(targets::queue_of(context, queue), targets::events_of(context, wait_list), targets);
    if (done == nullptr) return;
    clRetainEvent(last());
    *done = last();
}

void require_whole(const PlanState& state) {
    if (!state.is_whole)
        throw Error(ErrorCode::invalid_argument,
                    "the plan's last update failed, so that it has nothing to compute with; update it again");
    device::context_of(state.device).require_none_failed(state.failures);
}

}  // namespace

}  // namespace calls

std::unique_ptr<Plan::State> DistanceTransform::State::plan(bool has_own_pool, std::vector<Request> requests,
                                                            std::optional<OutputSet> outputs_without_targets,
                                                            const CallOptions& call, bool counts) {
    auto made = std::make_unique<Plan::State>(device, has_own_pool ? pool->beside() : pool, has_own_pool);
    made->counts = counts;
    plan(*made, std::move(requests), outputs_without_targets, call);
    return made;
}

void DistanceTransform::State::plan(calls::PlanState& made, std::vector<Request> requests,
                                    std::optional<OutputSet> outputs_without_targets, const CallOptions& call) {
    const device::Context& context = device::context_of(device);
    if (&device::context_of(made.device) != &context)
        throw Error(ErrorCode::invalid_argument,
                    "the transform has another device than the plan; update the plan with a transform of its Device");
    std::vector<engine::Job> jobs;
    const auto targets = calls::targets_of(requests, device_targets(jobs, outputs_without_targets, made.counts));
    mutex.check_thread();
    made.clear();  // waits for its runs before the mutex is locked: other threads may use the transform
    std::swap(made.requests, requests);
    std::swap(made.outputs_without_targets, outputs_without_targets);
    try {
        plan(made, jobs, targets, call);
    } catch (...) {
        std::swap(made.requests, requests);
        std::swap(made.outputs_without_targets, outputs_without_targets);
        made.clear();
        if (made.has_own_pool) made.pool->release();
        throw;
    }
}

void DistanceTransform::State::plan(calls::PlanState& made, std::span<const engine::Job> jobs,
                                    std::span<const targets::DeviceTargets> targets, const CallOptions& call) {
    device::Context& context = this->context();
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    calls::RunningCall running{call};
    running.throw_if_stopped();
    made.divide(jobs, targets, kept_mesh->box());
    if (made.has_copies()) test(calls::stored_boxes_subject(device, programs), running);
    for (const calls::Batch& batch : made.batches()) compile(batch.job, running);
    made.sign = sign;
    bool is_retry = false;
    const auto make = [&] {
        made.clear();
        if (std::exchange(is_retry, true) && made.has_own_pool) made.pool->release();
        // The set-up's commands use what is given back after an error.
        context.run_or_drain([&] {
            made.make_room();
            SlabPlans slab_plans(*this, made.pool, true, running);
            for (const calls::Slab& slab : made.slabs()) made.add(slab, slab_plans.make(slab), targets, programs);
            keep_within_budget();
        });
    };
    calls::with_remedies(&running, {forgetting()}, make);
    device::guarded([&] { context.finish(); });
    if (made.has_own_pool) made.pool->hand_back();
    made.complete(running.statistics, *kept_mesh);
    made.failures = failures;
}

CallStatistics DistanceTransform::State::compute_on_device(std::span<const Request> requests, const CallOptions& call) {
    const device::Context& context = this->context();
    const auto plan = this->plan(true, {requests.begin(), requests.end()}, std::nullopt, call, call.count_work);
    device::guarded([&] {
        const Stopwatch watch;
        const cl::Event end = plan->enqueue(context.callers_queue(), targets::events_of(context, call.wait_list), {});
        const std::size_t launched = context.kernels().launched().count();
        targets::wait_for(context, call.wait_list);  // whose failure is not that of a kernel
        context.wait(end, launched);
        if (call.count_work) plan->read_counters();
        plan->statistics.field_seconds = watch.seconds();
    });
    calls::RunningCall{call}.report({.fraction = 1});
    return plan->statistics;
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
    calls::require_whole(state);
    if (state.outputs_without_targets)
        throw Error(
            ErrorCode::invalid_argument,
            "the plan was made of a grid and has no targets; give this run targets, or make the plan of a request");
    with_host_memory("for a run of the plan",
                     [&] { device::guarded([&] { calls::enqueue_run(state, queue, wait_list, done, {}); }); });
}

void Plan::enqueue(cl_command_queue queue, std::span<const OutputTargets> targets, std::span<const cl_event> wait_list,
                   cl_event* done) {
    State& state = this->state();
    calls::require_whole(state);
    with_host_memory("for the targets of a run; give fewer", [&] {
        device::guarded([&] { calls::enqueue_run(state, queue, wait_list, done, state.targets_of(targets)); });
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
                     [&] { update(transform, calls::requests_of(blocks, 0, blocks.first.size()), call); });
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, OutputSet outputs, const CallOptions& call) const {
    return with_host_memory("for the plan", [&] {
        return Plan(state().plan(false, std::vector<Request>{{grid, band, {}}}, targets::extras_of(outputs), call));
    });
}

Plan DistanceTransform::plan(std::span<const Request> requests, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer requests", [&] {
        return Plan(state().plan(requests.size() != 1, {requests.begin(), requests.end()}, std::nullopt, call));
    });
}

Plan DistanceTransform::plan(const BlockSet& blocks, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer blocks",
                            [&] { return plan(calls::requests_of(blocks, 0, blocks.first.size()), call); });
}

std::size_t DistanceTransform::plan_bytes(std::span<const Request> requests, const CallOptions& call) const {
    return plan(requests, call).statistics().device_bytes;
}

std::size_t DistanceTransform::plan_bytes(const BlockSet& blocks, const CallOptions& call) const {
    return plan(blocks, call).statistics().device_bytes;
}

}  // namespace clsdf

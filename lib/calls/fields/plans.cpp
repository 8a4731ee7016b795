#include "calls/fields/slab_plans.hpp"
#include "checks/known_targets.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/refuse.hpp"
#include "core/stopwatch.hpp"
#include "plans/plan_state.hpp"
#include "targets/mapped_memory.hpp"

#include <optional>
#include <utility>

namespace clsdf {

std::unique_ptr<Plan::State> DistanceTransform::State::plan(bool has_own_pool, plans::AskedBoxes asked,
                                                            const CallOptions& call, bool counts) {
    auto made = std::make_unique<Plan::State>(device, has_own_pool ? pool->beside() : pool, has_own_pool, counts);
    plan(*made, std::move(asked), call);
    return made;
}

void DistanceTransform::State::plan(plans::PlanState& plan, plans::AskedBoxes asked, const CallOptions& call) {
    plan.require_device(device);
    std::vector<engine::Job> jobs;
    const auto targets =
        plans::targets_of(asked.requests, device_targets(jobs, asked.outputs_without_targets, plan.counts));
    mutex.check_thread();
    plan.give_back();
    make(plan, std::move(asked), call, [&](calls::RunningCall& running) {
        plan.divide(jobs, targets, kept_mesh->box());
        if (plan.has_copies()) test(checks::stored_boxes_subject(device, programs), running);
        for (const plans::Batch& batch : plan.batches()) compile(batch.job, running);
        set_up_slabs(plan, running, [&](const plans::Slab& slab, std::unique_ptr<engine::GridPlan> of_slab) {
            plan.add(slab, std::move(of_slab), targets, programs);
        });
        return plan.complete(running.statistics, *kept_mesh);
    });
}

CallStatistics DistanceTransform::State::compute_on_device(std::span<const Request> requests, const CallOptions& call) {
    const device::Context& context = this->context();
    const auto plan = this->plan(true, {{requests.begin(), requests.end()}}, call, call.count_work);
    device::guarded([&] {
        const Stopwatch watch;
        cl_event done = nullptr;
        plan->enqueue({nullptr, call.wait_list, &done});
        const cl::Event end(done);
        const std::size_t launched = context.kernels().launched().count();
        const cl_int code = clWaitForEvents(1, &done);  // PoCL 3.1 does not wake who waits for an event that fails
        targets::wait_for(context, call.wait_list);     // its failure is not that of a kernel
        context.wait(end, launched);
        if (code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
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
    return state().asked().requests;
}

SignRule Plan::sign() const {
    return state().sign;
}

const TransformStatistics& Plan::statistics() const {
    return state().published;
}

void Plan::enqueue(cl_command_queue queue, std::span<const cl_event> wait_list, cl_event* done) {
    State& state = this->state();
    state.require_whole();
    if (state.asked().outputs_without_targets)
        refuse("the plan was made of a grid and has no targets; give this run targets, or make the plan of a request");
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] { state.enqueue({queue, wait_list, done}); });
    });
}

void Plan::enqueue(cl_command_queue queue, std::span<const OutputTargets> targets, std::span<const cl_event> wait_list,
                   cl_event* done) {
    State& state = this->state();
    state.require_whole();
    with_host_memory("for the targets of a run; give fewer", [&] {
        device::guarded([&] { state.enqueue({queue, wait_list, done}, targets); });
    });
}

void Plan::enqueue(cl_command_queue queue, const OutputTargets& targets, std::span<const cl_event> wait_list,
                   cl_event* done) {
    enqueue(queue, std::span(&targets, 1), wait_list, done);
}

void Plan::update(const DistanceTransform& transform, const CallOptions& call) {
    with_host_memory("for the plan", [&] {
        State& state = this->state();
        transform.state().plan(state, state.asked(), call);
    });
}

void Plan::update(const DistanceTransform& transform, std::span<const Grid> grids, const CallOptions& call) {
    with_host_memory("for the plan; give fewer requests", [&] {
        State& state = this->state();
        plans::AskedBoxes asked = state.asked();
        if (grids.size() != asked.requests.size())
            refuse("the plan has {} requests, and {} grids are given; give one for each", asked.requests.size(),
                   grids.size());
        for (std::size_t n = 0; n < grids.size(); ++n) asked.requests[n].grid = grids[n];
        transform.state().plan(state, std::move(asked), call);
    });
}

void Plan::update(const DistanceTransform& transform, std::span<const Request> requests, const CallOptions& call) {
    with_host_memory("for the plan; give fewer requests", [&] {
        transform.state().plan(state(), {{requests.begin(), requests.end()}}, call);
    });
}

void Plan::update(const DistanceTransform& transform, const BlockSet& blocks, const CallOptions& call) {
    with_host_memory("for the plan; give fewer blocks",
                     [&] { update(transform, plans::requests_of(blocks, 0, blocks.first.size()), call); });
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, OutputSet outputs, const CallOptions& call) const {
    return with_host_memory("for the plan", [&] {
        return Plan(state().plan(false, {{{grid, band, {}}}, targets::extras_of(outputs)}, call));
    });
}

Plan DistanceTransform::plan(std::span<const Request> requests, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer requests", [&] {
        return Plan(state().plan(requests.size() != 1, {{requests.begin(), requests.end()}}, call));
    });
}

Plan DistanceTransform::plan(const BlockSet& blocks, const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer blocks",
                            [&] { return plan(plans::requests_of(blocks, 0, blocks.first.size()), call); });
}

std::size_t DistanceTransform::plan_bytes(std::span<const Request> requests, const CallOptions& call) const {
    return plan(requests, call).statistics().device_bytes;
}

std::size_t DistanceTransform::plan_bytes(const BlockSet& blocks, const CallOptions& call) const {
    return plan(blocks, call).statistics().device_bytes;
}

}  // namespace clsdf

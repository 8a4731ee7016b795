#include "calls/slab_plans.hpp"
#include "calls/sparse_plan_state.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "targets/mapped_memory.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <memory>
#include <utility>

namespace clsdf {

void DistanceTransform::State::plan(calls::SparsePlanState& made, SparseRequest request, SparseCounts room,
                                    const CallOptions& call) {
    const device::Context& context = device::context_of(device);
    if (&device::context_of(made.device) != &context)
        throw Error(ErrorCode::invalid_argument,
                    "the transform has another device than the plan; update the plan with a transform of its Device");
    const engine::Job job = check_sparse(request.grid, request.band, targets::extras_of(request.outputs), false);
    constexpr std::size_t most_room = std::size_t{1} << 40;
    if (room.bricks > most_room || room.runs > most_room)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the plan is to have room for {} bricks and {} runs, and no field has so many; give it "
                                "room for at most {}",
                                room.bricks, room.runs, most_room));
    mutex.check_thread();
    made.clear();  // waits for its runs before the mutex is locked: other threads may use the transform
    std::swap(made.request, request);
    std::swap(made.room, room);
    try {
        plan(made, job, call);
    } catch (...) {
        std::swap(made.request, request);
        std::swap(made.room, room);
        made.clear();
        throw;
    }
}

void DistanceTransform::State::plan(calls::SparsePlanState& made, const engine::Job& job, const CallOptions& call) {
    device::Context& context = this->context();
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    calls::RunningCall running{call};
    running.throw_if_stopped();
    made.divide(job);
    compile(job, running,
            {checks::field_subject(*this, job, checks::FieldKernels::of_sparse_fields),
             calls::ordered_bricks_subject(device, programs)});
    made.sign = sign;
    const auto make = [&] {
        made.clear();
        // The set-up's commands use what is given back after an error.
        context.run_or_drain([&] {
            made.make_room();
            SlabPlans slab_plans(*this, made.pool, true, running);
            for (const calls::Slab& slab : made.slabs()) made.add(slab_plans.make(slab), programs);
            keep_within_budget();
        });
    };
    calls::with_remedies(&running, {forgetting()}, make);
    device::guarded([&] { context.finish(); });
    made.complete(running.statistics, *kept_mesh);
    made.failures = failures;
}

SparsePlan::SparsePlan(std::unique_ptr<State> state) : state_(std::move(state)) {}
SparsePlan::SparsePlan(SparsePlan&&) noexcept = default;
SparsePlan& SparsePlan::operator=(SparsePlan&&) noexcept = default;
SparsePlan::~SparsePlan() = default;

SparsePlan::State& SparsePlan::state() const {
    return held_by(state_, "SparsePlan");
}

const SparseRequest& SparsePlan::request() const {
    return state().request;
}

const SparseCounts& SparsePlan::room() const {
    return state().room;
}

SignRule SparsePlan::sign() const {
    return state().sign;
}

const TransformStatistics& SparsePlan::statistics() const {
    return state().published;
}

void SparsePlan::enqueue(cl_command_queue queue, const SparseDeviceTargets& targets,
                         std::span<const cl_event> wait_list, cl_event* done) {
    State& state = this->state();
    if (!state.is_whole)
        throw Error(ErrorCode::invalid_argument,
                    "the plan's last update failed, so that it has nothing to compute with; update it again");
    device::context_of(state.device).require_none_failed(state.failures);
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] {
            const device::Context& context = device::context_of(state.device);
            const calls::OrderedTargets to = state.targets_of(targets);
            const cl::Event last =
                state.enqueue(targets::queue_of(context, queue), targets::events_of(context, wait_list), to);
            if (done == nullptr) return;
            clRetainEvent(last());
            *done = last();
        });
    });
}

void SparsePlan::update(const DistanceTransform& transform, const CallOptions& call) {
    update(transform, request(), room(), call);
}

void SparsePlan::update(const DistanceTransform& transform, const SparseRequest& request, const SparseCounts& room,
                        const CallOptions& call) {
    with_host_memory("for the plan", [&] { transform.state().plan(state(), request, room, call); });
}

SparsePlan DistanceTransform::plan_sparse(const SparseRequest& request, const SparseCounts& room,
                                          const CallOptions& call) const {
    return with_host_memory("for the plan", [&] {
        const State& self = state();
        auto made = std::make_unique<SparsePlan::State>(self.device, self.pool);
        state().plan(*made, request, room, call);
        return SparsePlan(std::move(made));
    });
}

}  // namespace clsdf

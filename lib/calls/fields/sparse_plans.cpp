#include "calls/fields/slab_plans.hpp"
#include "checks/known_targets.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/refuse.hpp"
#include "plans/sparse_plan_state.hpp"

#include <cstddef>
#include <memory>
#include <utility>

namespace clsdf {

void DistanceTransform::State::plan(plans::SparsePlanState& plan, const plans::AskedBricks& asked,
                                    const CallOptions& call) {
    plan.require_device(device);
    const auto& [request, room] = asked;
    const engine::Job job = check_sparse(request.grid, request.band, targets::extras_of(request.outputs), false);
    constexpr std::size_t most_room = std::size_t{1} << 40;
    if (room.bricks > most_room || room.runs > most_room)
        refuse(
            "the plan is to have room for {} bricks and {} runs, and no field has so many; give it "
            "room for at most {}",
            room.bricks, room.runs, most_room);
    mutex.check_thread();
    plan.give_back();
    make(plan, asked, call, [&](calls::RunningCall& running) {
        plan.divide(job);
        compile(job, running,
                {checks::field_subject(*this, job, checks::FieldKernels::of_sparse_fields),
                 checks::ordered_bricks_subject(device, programs)});
        set_up_slabs(plan, running, [&](const plans::Slab&, std::unique_ptr<engine::GridPlan> of_slab) {
            plan.add(std::move(of_slab), programs);
        });
        return plan.complete(running.statistics, *kept_mesh);
    });
}

SparsePlan::SparsePlan(std::unique_ptr<State> state) : state_(std::move(state)) {}
SparsePlan::SparsePlan(SparsePlan&&) noexcept = default;
SparsePlan& SparsePlan::operator=(SparsePlan&&) noexcept = default;
SparsePlan::~SparsePlan() = default;

SparsePlan::State& SparsePlan::state() const {
    return held_by(state_, "SparsePlan");
}

const SparseRequest& SparsePlan::request() const {
    return state().asked().request;
}

const SparseCounts& SparsePlan::room() const {
    return state().asked().room;
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
    state.require_whole();
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] { state.enqueue({queue, wait_list, done}, targets); });
    });
}

void SparsePlan::update(const DistanceTransform& transform, const CallOptions& call) {
    update(transform, request(), room(), call);
}

void SparsePlan::update(const DistanceTransform& transform, const SparseRequest& request, const SparseCounts& room,
                        const CallOptions& call) {
    with_host_memory("for the plan", [&] { transform.state().plan(state(), {request, room}, call); });
}

SparsePlan DistanceTransform::plan_sparse(const SparseRequest& request, const SparseCounts& room,
                                          const CallOptions& call) const {
    return with_host_memory("for the plan", [&] {
        State& self = state();
        auto made = std::make_unique<SparsePlan::State>(self.device, self.pool);
        self.plan(*made, {request, room}, call);
        return SparsePlan(std::move(made));
    });
}

}  // namespace clsdf

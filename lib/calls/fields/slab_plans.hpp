#pragma once

#include "calls/transform/planning.hpp"
#include "calls/transform/transform_state.hpp"

#include <memory>
#include <utility>

namespace clsdf {

/// Makes the plans of slabs, one after another, under the transform's mutex. The inputs of a batch are made once, and
/// each of its slabs gets the part that it needs.
class DistanceTransform::State::SlabPlans {
public:
    /// All references must outlive this. pool: of the plans' buffers. lone: see engine::grid_inputs().
    SlabPlans(State& state, std::shared_ptr<device::BufferPool> pool, bool lone, calls::RunningCall& running)
        : state_(state), workshop_(state.with(std::move(pool))), lone_(lone), running_(running) {}

    /// in_halves: see GridPlan. Throws what engine::grid_inputs() and GridPlan do, and what the caller's functions do.
    std::unique_ptr<engine::GridPlan> make(const plans::Slab& slab, bool in_halves = false);
    /// Gives back the inputs of the latest batch.
    void release() {
        batch_ = nullptr;
        inputs_ = {};
    }

private:
    engine::Inputs inputs_of(const engine::Job& job) const;
    engine::MakeSignBits exact_signs(const engine::Job& job) const;
    engine::MakeSignBits exact_signs_by_host(const engine::Job& job) const;

    State& state_;
    engine::Workshop workshop_;
    bool lone_;
    calls::RunningCall& running_;
    const plans::Batch* batch_ = nullptr;
    engine::Inputs inputs_;  ///< of the batch
};

/// What make_and_wait() does, for the slabs of a plan that has been divided. add(slab, its GridPlan).
template <class Plan, class Add>
void DistanceTransform::State::set_up_slabs(Plan& plan, calls::RunningCall& running, const Add& add) {
    bool is_retry = false;
    make_and_wait(running, [&] {
        plan.clear();
        if (std::exchange(is_retry, true) && plan.has_own_pool) plan.pool->release();
        plan.make_room();
        SlabPlans slab_plans(*this, plan.pool, true, running);
        for (const plans::Slab& slab : plan.slabs()) add(slab, slab_plans.make(slab));
        keep_within_budget();
    });
    if (plan.has_own_pool) plan.pool->hand_back();
}

}  // namespace clsdf

#pragma once

#include "calls/transform_state.hpp"

#include <memory>

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

}  // namespace clsdf

#pragma once

#include "calls/transform_state.hpp"

#include <memory>

namespace clsdf {

/// Makes the plans of blocks, one after another, under the transform's mutex. The inputs of a batch are made once, and
/// each of its blocks gets the part that it needs.
class DistanceTransform::State::BlockPlans {
public:
    /// All references must outlive this. pool: of the plans' buffers. lone: see KeptMesh::inputs().
    BlockPlans(State& state, std::shared_ptr<device::BufferPool> pool, bool lone, transform::RunningCall& running)
        : state_(state), workshop_(state.with(std::move(pool))), lone_(lone), running_(running) {}

    /// Throws what KeptMesh::inputs() and GridPlan do, and what the caller's functions do.
    std::unique_ptr<transform::GridPlan> make(const transform::Block& block);
    /// Gives back the inputs of the latest batch.
    void release() {
        batch_ = nullptr;
        inputs_ = {};
    }

private:
    transform::Inputs inputs_of(const transform::Job& job) const;

    State& state_;
    transform::Workshop workshop_;
    bool lone_;
    transform::RunningCall& running_;
    const transform::Batch* batch_ = nullptr;
    transform::Inputs inputs_;  ///< of the batch
};

}  // namespace clsdf

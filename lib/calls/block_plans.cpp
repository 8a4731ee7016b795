#include "calls/block_plans.hpp"

#include "core/stopwatch.hpp"

#include <utility>

namespace clsdf {

engine::Inputs DistanceTransform::State::BlockPlans::inputs_of(const engine::Job& job) const {
    engine::KeptMesh& kept_mesh = *state_.kept_mesh;
    const SignRule sign = state_.sign;
    return calls::with_remedies(nullptr, {state_.forgetting()}, [&] {
        engine::Inputs inputs = kept_mesh.inputs(job.grid, job.band, sign, lone_);
        if (job.outputs == OutputSet{} || state_.method) return inputs;
        const bool has_normals = engine::takes_normals(job.outputs);
        inputs.sites =
            kept_mesh.sites(engine::names_sites(job.outputs), has_normals && kept_mesh.may_meet_samples(job.grid));
        inputs.is_inside_out = has_normals && state_.topology.balanced && kept_mesh.encloses_negative_volume();
        return inputs;
    });
}

std::unique_ptr<engine::GridPlan> DistanceTransform::State::BlockPlans::make(const calls::Block& block) {
    const engine::Job job = block.batch->job.part(block.grid);
    if (batch_ != block.batch) {
        const Stopwatch watch;
        release();
        inputs_ = inputs_of(block.batch->job);
        running_.statistics.polyhedra_seconds += watch.seconds();
        if (inputs_.records->is_later)
            state_.test(checks::field_subject(state_, job, checks::FieldKernels::of_later_lattices), running_);
        running_.throw_if_stopped();
        batch_ = block.batch;
    }
    engine::Inputs inputs = inputs_;
    if (!block.is_whole()) state_.kept_mesh->select(job.grid, job.band, state_.sign, inputs);
    auto plan =
        std::make_unique<engine::GridPlan>(workshop_, std::move(inputs), job, [&] { running_.throw_if_stopped(); });
    workshop_.pool->trim();
    return plan;
}

}  // namespace clsdf

#include "calls/slab_plans.hpp"

#include "core/stopwatch.hpp"

#include <utility>

namespace clsdf {

engine::Inputs DistanceTransform::State::SlabPlans::inputs_of(const engine::Job& job) const {
    engine::KeptMesh& kept_mesh = *state_.kept_mesh;
    return calls::with_remedies(nullptr, {state_.forgetting()}, [&] {
        engine::Inputs inputs = engine::grid_inputs(kept_mesh, job, state_.sign, lone_);
        if (job.outputs == OutputSet{} || state_.method) return inputs;
        const NormalsNeeded normals = state_.normals_for(job.outputs);
        inputs.sites = kept_mesh.sites(engine::names_sites(job.outputs), normals.are_needed && inputs.needs_normals);
        inputs.is_inside_out = normals.is_inside_out;
        return inputs;
    });
}

std::unique_ptr<engine::GridPlan> DistanceTransform::State::SlabPlans::make(const plans::Slab& slab, bool in_halves) {
    const engine::Job job = slab.batch->job.with_grid(slab.grid);
    if (batch_ != slab.batch) {
        const Stopwatch watch;
        release();
        inputs_ = inputs_of(slab.batch->job);
        running_.statistics.polyhedra_seconds += watch.seconds();
        if (inputs_.records->from_kept_frusta)
            state_.test(checks::field_subject(state_, job, checks::FieldKernels::of_kept_frusta), running_);
        running_.throw_if_stopped();
        batch_ = slab.batch;
    }
    engine::Inputs inputs = inputs_;
    if (!slab.is_whole()) engine::select_inputs(*state_.kept_mesh, job, inputs);
    auto plan = std::make_unique<engine::GridPlan>(
        workshop_, std::move(inputs), job, [&] { running_.throw_if_stopped(); }, in_halves);
    workshop_.pool->trim();
    return plan;
}

}  // namespace clsdf

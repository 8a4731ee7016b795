#include "calls/fields/slab_plans.hpp"

#include "checks/known_segments.hpp"
#include "core/stopwatch.hpp"
#include "segments/sign_bits.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
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

engine::MakeSignBits DistanceTransform::State::SlabPlans::exact_signs(const engine::Job& job) const {
    const std::optional<engine::CrossedMesh> mesh =
        calls::with_remedies(nullptr, {state_.forgetting()}, [&] { return state_.kept_mesh->crossed_mesh(); });
    if (!mesh || job.layout.bricks[0] * CLSDF_BRICK > CLSDF_MOST_EXACT_SAMPLES) return exact_signs_by_host(job);
    state_.test(checks::exact_sides_subject(state_.device, state_.programs), running_);
    return [this, mesh, job](const Layout& layout) {
        const engine::ShortLaunches launches(state_.context(), [this] { running_.throw_if_stopped(); });
        auto bits = segments::sign_bits_by_kernels(workshop_.tools(), launches, *mesh, state_.sign, job.grid, layout);
        return bits ? std::move(*bits) : exact_signs_by_host(job)(layout);
    };
}

engine::MakeSignBits DistanceTransform::State::SlabPlans::exact_signs_by_host(const engine::Job& job) const {
    const auto mesh =
        calls::with_remedies(nullptr, {state_.forgetting()}, [&] { return state_.kept_points->sign_mesh(); });
    if (!engine::are_exact(*mesh)) engine::refuse_inexact(*mesh, state_.kept_mesh->name());
    auto near = engine::faces_near_rows(*state_.kept_mesh, job);
    // The walls of the rule below follow the mesh's faces.
    if (near) near->faces.push_back({state_.kept_mesh->face_count(), mesh->face_count()});
    return [this, mesh, near, grid = job.grid](const Layout& layout) {
        return segments::sign_bits_by_host(workshop_.tools(), {*mesh, state_.kept_mesh->numbers()}, state_.sign, grid,
                                           layout, near ? &near->faces : nullptr);
    };
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
    if (job.band.has_exact_signs) inputs.make_sign_bits = exact_signs(job);
    auto plan = std::make_unique<engine::GridPlan>(
        workshop_, std::move(inputs), job, [&] { running_.throw_if_stopped(); }, in_halves);
    workshop_.pool->trim();
    return plan;
}

}  // namespace clsdf

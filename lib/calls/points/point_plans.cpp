#include "calls/transform/planning.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/refuse.hpp"
#include "core/stopwatch.hpp"
#include "plans/point_plan_state.hpp"
#include "points/usable_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace clsdf {

void DistanceTransform::State::plan(plans::PointPlanState& plan, const plans::AskedPoints& asked,
                                    const CallOptions& call) {
    plan.require_device(device);
    if (kept_mesh->restriction() != nullptr)
        refuse_unsupported(
            "the transform is restricted, and points of a plan, which the host does not see, may lie beyond "
            "its regions; plan points of the whole transform");
    make(plan, asked, call, [&](calls::RunningCall& running) {
        const bool by_group = programs.body == KernelBody::by_group;
        test(checks::point_subject(device, programs,
                                   by_group ? checks::PointKernels::of_all : checks::PointKernels::of_plans),
             running);
        const Stopwatch watch;
        plans::PlannedPoints made;
        make_and_wait(running, [&] {
            made.run.reset();
            made.inputs = planned_point_inputs(asked.outputs);
            if (!plan.needs_memory(programs)) return;
            made.run.emplace(tools(), std::min(asked.count, points::most_points));
            made.packed.make_room(*pool, asked.outputs, made.run->most());
        });
        if (made.inputs.needs_deep_stack())
            test(checks::point_subject(device, programs, checks::PointKernels::of_deep_trees), running);
        plan.replace(std::move(made), programs);
        CallStatistics& statistics = running.statistics;
        statistics.triangles = kept_mesh->face_count();
        statistics.polyhedra_seconds = watch.seconds();
        statistics.device_bytes = plan.device_bytes();
        return statistics;
    });
}

points::PointInputs DistanceTransform::State::planned_point_inputs(OutputSet outputs) {
    points::PointInputs inputs;
    inputs.mesh = kept_points->faces();
    inputs.sign_faces = kept_points->sign_faces(sign);
    if (!inputs.has_exact_signs())
        refuse(
            "{} has a coordinate that is not 0 and, in units of {}, smaller than 2^-300 or greater "
            "than 2^300: a plan of points cannot decide signs then; set such coordinates to 0, or "
            "ask with query()",
            kept_mesh->name(), inputs.mesh->lattice.unit);
    inputs.triangles = kept_points->triangles();
    if (programs.body == KernelBody::by_group)
        inputs.tree = kept_points->fitted_tree();
    else
        inputs.leaves = kept_points->wide_leaves();
    if (sign != SignRule::none) inputs.sides = kept_points->face_sides(sign, true);
    const NormalsNeeded normals = normals_for(outputs);
    inputs.sites = kept_points->sites(outputs, normals.are_needed, inputs.sides.get());
    inputs.sign = sign;
    inputs.is_inside_out = normals.is_inside_out;
    return inputs;
}

PointPlan::PointPlan(std::unique_ptr<State> state) : state_(std::move(state)) {}
PointPlan::PointPlan(PointPlan&&) noexcept = default;
PointPlan& PointPlan::operator=(PointPlan&&) noexcept = default;
PointPlan::~PointPlan() = default;

PointPlan::State& PointPlan::state() const {
    return held_by(state_, "PointPlan");
}

std::size_t PointPlan::count() const {
    return state().asked().count;
}

double PointPlan::half_width() const {
    return state().asked().half_width;
}

OutputSet PointPlan::outputs() const {
    return state().asked().outputs;
}

SignRule PointPlan::sign() const {
    return state().sign;
}

const TransformStatistics& PointPlan::statistics() const {
    return state().published;
}

void PointPlan::enqueue(cl_command_queue queue, const InputArray& points, const OutputTargets& targets,
                        std::span<const cl_event> wait_list, cl_event* done, const OutputArray& status) {
    State& state = this->state();
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] { state.enqueue({queue, wait_list, done}, points, targets, status); });
    });
}

void PointPlan::update(const DistanceTransform& transform, const CallOptions& call) {
    with_host_memory("for the plan", [&] {
        State& state = this->state();
        transform.state().plan(state, plans::AskedPoints(state.asked()), call);
    });
}

PointPlan DistanceTransform::plan_points(std::size_t count, double half_width, OutputSet outputs,
                                         const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer points", [&] {
        State& state = this->state();
        points::check_half_width(half_width);
        if (count == 0 || count >= std::numeric_limits<cl_uint>::max())
            refuse("a plan is asked for that takes {} points at a time; it takes 1 to 2^32 - 2", count);
        auto made = std::make_unique<PointPlan::State>(state.device, state.pool, state.programs);
        state.plan(*made, {count, std::abs(half_width), targets::extras_of(outputs) | Output::distance}, call);
        return PointPlan(std::move(made));
    });
}

}  // namespace clsdf

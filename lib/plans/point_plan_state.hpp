#pragma once

#include <clsdf/point_plan.hpp>

#include "launch/programs.hpp"
#include "plans/planned.hpp"
#include "points/packed_outputs.hpp"
#include "points/point_run.hpp"
#include "targets/output_targets.hpp"

#include <optional>

namespace clsdf::plans {

/// The points that a PointPlan looks up.
struct AskedPoints {
    std::size_t count = 0;  ///< at most
    double half_width = 0;
    OutputSet outputs{};  ///< with the distance
};

/// The inputs at positions of a transform, and the memory of a batch.
struct PlannedPoints {
    points::PointInputs inputs;
    std::optional<points::PointRun> run;
    points::PackedOutputs packed;
};

/// The state of a PointPlan.
class PointPlanState : public Planned<AskedPoints, PlannedPoints> {
public:
    PointPlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in, engine::Programs programs)
        : Planned(std::move(device_in), std::move(pool_in), false), programs_(std::move(programs)) {}

    /// Whether runs by these programs take other memory than the plan has.
    bool needs_memory(const engine::Programs& programs) const { return !made_.run || programs_.body != programs.body; }
    /// Runs use this from now on. Without a run in it the plan keeps its memory.
    void replace(PlannedPoints made, engine::Programs programs) noexcept;

    std::size_t device_bytes() const { return made_.run->device_bytes() + made_.packed.device_bytes(); }

    /// Throws as PointPlan::enqueue() does.
    void enqueue(const RunOptions& options, const InputArray& points, const OutputTargets& targets,
                 const OutputArray& status);

private:
    engine::DeviceTools tools() const { return {context(), pool, programs_}; }
    /// The targets, checked together with points and status.
    targets::DeviceTargets check(const InputArray& points, const OutputTargets& targets,
                                 const OutputArray& status) const;
    void enqueue_batches(engine::CommandChain& chain, const InputArray& points, const OutputTargets& targets,
                         const targets::DeviceTargets& checked, const std::optional<OutputArray>& status);

    engine::Programs programs_;
};

}  // namespace clsdf::plans

namespace clsdf {

struct __attribute__((visibility("hidden"))) PointPlan::State : plans::PointPlanState {
    using PointPlanState::PointPlanState;
};

}  // namespace clsdf

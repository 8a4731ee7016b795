#pragma once

#include <clsdf/point_plan.hpp>

#include "calls/runs.hpp"
#include "device/buffer_pool.hpp"
#include "launch/programs.hpp"
#include "points/packed_outputs.hpp"
#include "points/point_run.hpp"
#include "targets/output_targets.hpp"

#include <optional>
#include <vector>

namespace clsdf::calls {

/// The checks of points and targets in memory of the device, whose layouts are checked by DeviceTargets. Throws
/// Error(invalid_argument) if the memory of points of the device is no buffer of the context, may not be read by
/// kernels or is too small.
void check_device_points(const device::Context& context, const InputArray& points);
/// Whether a result of some point may lie on the coordinates of points.
bool may_overlap(const InputArray& points, const targets::DeviceTargets& targets);
/// Throws Error(invalid_argument) unless a half width is one.
void check_half_width(double half_width);

/// A plan of points: the inputs at positions of a transform, the memory of a batch, and the runs.
struct PointPlanState {
    PointPlanState(Device device_in, engine::Programs programs_in, std::shared_ptr<device::BufferPool> pool_in)
        : device(std::move(device_in)), programs(std::move(programs_in)), pool(std::move(pool_in)) {}
    PointPlanState(const PointPlanState&) = delete;
    PointPlanState& operator=(const PointPlanState&) = delete;
    /// Waits for all runs.
    ~PointPlanState();

    device::Context& context() const { return device::context_of(device); }
    engine::DeviceTools tools() const { return {context(), pool, programs}; }
    /// Throws Error(device_failure).
    void wait();
    std::size_t own_bytes() const { return (run ? run->device_bytes() : 0) + packed.device_bytes(); }

    /// Throws as PointPlan::enqueue() does.
    cl::Event enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before, const InputArray& points,
                      const OutputTargets& targets, const OutputArray& status);

    Device device;
    engine::Programs programs;
    std::shared_ptr<device::BufferPool> pool;
    std::size_t count = 0;
    double half_width = 0;
    OutputSet outputs;  ///< with the distance
    points::PointInputs inputs;
    std::optional<points::PointRun> run;
    points::PackedOutputs packed;
    TransformStatistics published;
    std::size_t failures = 0;  ///< of the transform that it was made of

private:
    /// The targets, checked together with points and status.
    targets::DeviceTargets check(const InputArray& points, const OutputTargets& targets,
                                 const OutputArray& status) const;

    Runs runs_;
};

}  // namespace clsdf::calls

namespace clsdf {

struct __attribute__((visibility("hidden"))) PointPlan::State : calls::PointPlanState {
    using PointPlanState::PointPlanState;
};

}  // namespace clsdf

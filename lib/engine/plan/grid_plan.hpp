#pragma once

#include "bricks/field_scan.hpp"
#include "plan/grid_inputs.hpp"
#include "plan/job.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace clsdf::engine {

/// A job's buffers and launches. `between_launches` of the set-up may throw. A plan is destroyed when its commands have
/// ended, unless the device is lost.
struct GridPlan {
    /// in_halves: the lower half of the samples is complete before the upper one is computed, if that can be.
    GridPlan(const Workshop& workshop, Inputs inputs_in, const Job& job_in,
             const std::function<void()>& between_launches, bool in_halves = false);

    GridPlan(const GridPlan&) = delete;
    GridPlan& operator=(const GridPlan&) = delete;

    /// Adds the commands of a computation. If the set-up or the computation before may still run on another queue, the
    /// chain's wait list must have their events. `between_launches` (may be empty) is called with the fraction done
    /// before each launch, when the commands before it have ended.
    void enqueue(CommandChain& chain, const OutputBuffers& buffers,
                 const std::function<void(double)>& between_launches);

    /// Samples that are complete when a command has ended.
    struct Samples {
        std::size_t end = 0;  ///< before this one
        cl::Event complete;
    };
    /// The lower half of the latest computation; no samples if all are complete at the end.
    const Samples& lower_half() const { return lower_half_; }

    /// Sets the counters and the kernels' times of the last computation, which has ended: the counters if the job has
    /// them, the times if its queue measures them.
    void read_back(const cl::CommandQueue& queue);

    Device device;
    Inputs inputs;
    Job job;
    CallStatistics statistics;

    /// The marks of the bricks of a sparse field, when it has been computed: see FieldScan.
    cl::Buffer marks() const { return scan_->marks(); }

    /// Device memory of this plan alone, without the records, which are shared.
    std::size_t own_bytes() const { return statistics.device_bytes - inputs.records->device_bytes(); }

private:
    device::BufferPool::Lease sign_bits_;
    std::optional<Finishing> finishing_;  ///< if more than the distance is asked for
    std::unique_ptr<FieldScan> scan_;
    // Events of the latest computation.
    cl::Event before_launches_;
    cl::Event after_launches_;
    cl::Event last_;
    Samples lower_half_;
};

}  // namespace clsdf::engine

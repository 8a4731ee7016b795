#pragma once

#include <clsdf/distance_transform.hpp>

#include "scan/field_scan.hpp"
#include "scan/programs.hpp"
#include "transform/stages.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace clsdf::transform {

struct PlanOptions {
    bool count = false;  ///< see CallOptions::count
    std::shared_ptr<const FieldMethod> method{};
    /// The blocks whose samples are needed; other samples may stay undefined. Empty: all samples are needed.
    std::vector<Grid> wanted{};
};

/// A plan's buffers and launches, for one grid or slab. `between_launches` of the set-up may throw.
struct GridPlan {
    GridPlan(Device device_in, std::shared_ptr<device::BufferPool> pool_in, const Programs& programs, Inputs inputs_in,
             const Grid& grid_in, const Band& band_in, SignRule sign_in, OutputSet outputs_in,
             const PlanOptions& options, const std::function<void()>& between_launches);

    /// No command that uses it may be under way, unless the device is lost.
    ~GridPlan();
    GridPlan(const GridPlan&) = delete;
    GridPlan& operator=(const GridPlan&) = delete;

    /// Adds the commands of a computation. If the set-up or the computation before may still run on another queue, the
    /// chain's wait list must have their events. `between_launches` (may be empty) is called with the fraction done
    /// before each launch, when the commands before it have ended.
    void enqueue(CommandChain& chain, const OutputBuffers& buffers,
                 const std::function<void(double)>& between_launches);

    /// Adds the counters of the last computation to the statistics, if PlanOptions::count is set.
    void read_counters();

    /// Reads the kernels' times of the last computation, which has ended, if its queue measures them.
    void read_times(const cl::CommandQueue& queue);

    Device device;
    std::shared_ptr<device::BufferPool> pool;
    Inputs inputs;
    Grid grid;
    Band band;
    SignRule sign;
    OutputSet outputs;
    std::vector<Grid> wanted;  ///< see PlanOptions
    CallStatistics statistics;
    bool has_large_triangles = false;  ///< see SignBits

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
};

}  // namespace clsdf::transform

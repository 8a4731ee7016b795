#pragma once

#include <clsdf/distance_transform.hpp>

#include "scan/field_scan.hpp"
#include "scan/programs.hpp"
#include "transform/runs.hpp"
#include "transform/stages.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace clsdf::transform {

struct PlanOptions {
    bool count = false;  ///< see CallOptions::count
    std::shared_ptr<const FieldMethod> method{};
    std::vector<Grid> wanted{};  ///< blocks of the lattice outside which samples may be left undefined; empty: none are
};

/// A plan's buffers and launches, for one grid or slab. `between_launches` of the set-up may throw.
struct GridPlan {
    GridPlan(Device device_in, std::shared_ptr<device::BufferPool> pool_in, const Programs& programs, Inputs inputs_in,
             const Grid& grid_in, const Band& band_in, SignRule sign_in, const Outputs& outputs_in,
             const PlanOptions& options, const std::function<void()>& between_launches);

    /// Waits for what is under way: its buffers go back to the pool.
    ~GridPlan();
    GridPlan(const GridPlan&) = delete;
    GridPlan& operator=(const GridPlan&) = delete;

    /// As Plan::enqueue; `between_launches` (may be empty) is called with the fraction done before each launch.
    cl::Event enqueue(const cl::CommandQueue& queue, const OutputBuffers& buffers,
                      const std::vector<cl::Event>& wait_list, const std::function<void(double)>& between_launches);

    /// The end of what is under way; null if nothing is.
    cl::Event latest() { return runs_.latest(); }

    /// Reads the counters of the last computation into the statistics, where it was asked for.
    void read_counters();

    /// Reads the kernels' times of the last computation, which has ended, where the queue it ran on keeps them.
    void read_times(const cl::CommandQueue& queue);

    Device device;
    std::shared_ptr<device::BufferPool> pool;
    Inputs inputs;
    Grid grid;
    Band band;
    SignRule sign;
    Outputs outputs;
    std::vector<Grid> wanted;  ///< see PlanOptions
    TransformStatistics statistics;
    bool has_large_triangles = false;  ///< see SignBits

    /// Device memory of this plan alone, without the records, which are shared.
    std::size_t own_bytes() const { return statistics.device_bytes - inputs.records->device_bytes(); }

private:
    device::BufferPool::Lease sign_bits_;
    std::optional<Finishing> finishing_;  ///< if more than the distance is asked for
    std::unique_ptr<FieldScan> scan_;
    cl::Event ready_;  ///< the set-up's launches have ended: computations may run on another queue
    Runs runs_;        // the set-up's launches among them
    // Events of the latest computation.
    cl::Event before_launches_;
    cl::Event after_launches_;
    cl::Event last_;
};

}  // namespace clsdf::transform

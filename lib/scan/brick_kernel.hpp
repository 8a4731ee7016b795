#pragma once

#include <clsdf/distance_transform.hpp>

#include "scan/coarse_lists.hpp"
#include "scan/field_scan.hpp"

#include <memory>
#include <vector>

namespace clsdf::scan {

/// Computes the samples of all bricks that a polyhedron overlaps, in launches of bounded length.
class BrickKernel {
public:
    virtual ~BrickKernel() = default;

    std::size_t launch_count() const { return launches_.size(); }
    /// The share of the work that lies before a launch.
    double fraction_before(std::size_t launch) const { return launches_[launch].fraction_before; }

    /// Sets the arguments that change from call to call, and enqueues what must precede the first launch.
    virtual void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) = 0;
    virtual void enqueue_launch(CommandChain& chain, std::size_t launch) = 0;

    /// Sums of CLSDF_COUNTERS counters of the last computation; blocks. Empty where nothing is counted.
    std::vector<std::size_t> read_counters(const cl::CommandQueue& queue) const;

    virtual std::size_t device_bytes() const { return counters_.bytes(); }

protected:
    /// Coarse bricks order[begin, end) of one launch.
    struct Launch {
        cl_uint begin;
        cl_uint end;
        double fraction_before;
    };

    BrickKernel(const ScanInputs& inputs, const CoarseLists& lists, double pairs_per_launch, std::size_t counter_sets);

    /// Sets the last arguments, from number `first` on: the distance, then those of Finishing and the counters if they
    /// are asked for.
    void set_outputs(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const;

    std::vector<Launch> launches_;
    const Finishing* finishing_;
    cl::Buffer order_;
    device::BufferPool::Lease counters_;
    std::size_t counter_sets_;  ///< 0: nothing is counted
};

/// `computed` gets a mark for each brick that is computed. Both it and the lists must outlive the kernel.
std::unique_ptr<BrickKernel> make_bricks_by_vector(const ScanInputs& inputs, const CoarseLists& lists,
                                                   const cl::Buffer& computed);
std::unique_ptr<BrickKernel> make_bricks_by_group(const ScanInputs& inputs, const CoarseLists& lists,
                                                  const cl::Buffer& computed);

}  // namespace clsdf::scan

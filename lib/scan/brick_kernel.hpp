#pragma once

#include <clsdf/distance_transform.hpp>

#include "scan/coarse_lists.hpp"
#include "scan/commands.hpp"
#include "scan/finishing.hpp"
#include "scan/prepared_mesh.hpp"
#include "scan/programs.hpp"

#include <memory>
#include <vector>

namespace clsdf::scan {

/// The inputs of a brick kernel; they must outlive the kernel.
struct BrickInputs {
    Layout layout;
    const PreparedMesh& mesh;
    const CoarseLists& lists;
    const cl::Buffer& sign_bits;
    const cl::Buffer& computed;  ///< written: a mark for each computed brick
    const Finishing* finishing;  ///< null if the distance alone is asked for
};

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

    BrickKernel(device::Context& context, const std::shared_ptr<device::BufferPool>& pool, const BrickInputs& inputs,
                double pairs_per_launch, std::size_t counter_sets);

    /// Sets the last arguments: the distance, then those of Finishing and the counters if they are asked for.
    void set_outputs(cl::Kernel& kernel, cl_uint distance, const OutputBuffers& outputs) const;

    std::vector<Launch> launches_;
    const Finishing* finishing_;
    cl::Buffer order_;
    device::BufferPool::Lease counters_;
    std::size_t counter_sets_;  ///< 0: nothing is counted
};

std::unique_ptr<BrickKernel> make_bricks_by_vector(device::Context& context, const Programs& programs,
                                                   const std::shared_ptr<device::BufferPool>& pool,
                                                   const BrickInputs& inputs, const BrickVariant& variant);
std::unique_ptr<BrickKernel> make_bricks_by_group(device::Context& context, const Programs& programs,
                                                  const std::shared_ptr<device::BufferPool>& pool,
                                                  const BrickInputs& inputs, const BrickVariant& variant);

}  // namespace clsdf::scan

#pragma once

#include "bricks/field_scan.hpp"
#include "lists/coarse_lists.hpp"

#include <memory>
#include <vector>

namespace clsdf::engine {

/// Coarse bricks order[begin, end) of the lists, which a launch computes.
struct BrickLaunch {
    cl_uint begin;
    cl_uint end;
    double fraction_before;  ///< the share of the work that lies before it
};

/// The work of a launch, in pairs of a polyhedron and a coarse brick.
struct LaunchWork {
    double pairs;                 ///< at most about so many
    double pairs_of_a_brick = 0;  ///< that take as long as a coarse brick without any: its samples are stored
};

/// Some drivers count the work-items of a launch in 32 bits. A launch begins with the first brick of the upper half,
/// order[upper_begin].
std::vector<BrickLaunch> launches_of(const CoarseLists& lists, const LaunchWork& most, cl_uint upper_begin = 0);

/// The scan of leaned polyhedra by bricks: lists of the polyhedra that overlap each coarse brick, the samples of all
/// bricks that a polyhedron overlaps, and the fill of the others. A body computes the samples.
class BrickScan : public FieldScan {
public:
    std::size_t launch_count() const final { return launches_.size(); }
    double fraction_before(std::size_t launch) const final { return launches_[launch].fraction_before; }
    void enqueue_begin(CommandChain& chain, const OutputBuffers& outputs) final;
    void enqueue_end(CommandChain& chain) final;
    LowerHalf lower_half() const final { return lower_; }
    void enqueue_lower_end(CommandChain& chain) final;
    cl::Buffer marks() const final { return *computed_; }
    void describe(CallStatistics& statistics) const override;
    void read_counters(const device::Context& context, CallStatistics& statistics) const final;

protected:
    BrickScan(const ScanInputs& inputs, const LaunchWork& most);

    /// Sets of counters that the samples' kernel counts in; 0: nothing is counted.
    void make_counters(const ScanInputs& inputs, std::size_t sets);

    /// Sets the arguments that change from call to call, and enqueues what must precede the first launch.
    virtual void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) = 0;

    /// Sets the last arguments, from number `first` on: the distance, then those of Finishing and the counters if they
    /// are asked for.
    void set_outputs(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const;

    CoarseLists lists_;
    std::vector<BrickLaunch> launches_;
    device::BufferPool::Lease order_;
    device::BufferPool::Lease computed_;  ///< a mark for each brick that is computed

private:
    struct Slices {
        std::size_t begin, end;
    };

    void specialise_fill(const ScanInputs& inputs);
    void divide_in_halves(const LaunchWork& most);
    void enqueue_fill(CommandChain& chain, const Slices& slices);
    void enqueue_slices(CommandChain& chain, device::LentKernel& kernel, cl_uint last_argument, std::size_t most,
                        const Slices& slices) const;
    void enqueue_other_bricks(CommandChain& chain);
    std::size_t in_groups(std::size_t slices) const;

    Layout layout_;
    std::size_t bricks_;
    std::size_t fill_group_pieces_;
    std::size_t fill_group_slices_;
    std::size_t fill_pieces_;  ///< of a row of bricks, a work-item each
    std::size_t slices_per_fill_;
    device::BufferPool::Lease first_marks_;  ///< of the bricks; empty: all 0
    device::LentKernel fill_kernel_;
    device::LentKernel leave_kernel_;
    device::LentKernel mark_kernel_;
    const Finishing* finishing_;  ///< null if only floats are written
    cl_uint fill_outputs_;        ///< the kernels' first arguments that change from call to call
    cl_uint leave_outputs_;
    cl_uint mark_outputs_;
    LowerHalf lower_;
    OutputBuffers outputs_;  ///< of the computation that is being enqueued
    device::BufferPool::Lease counters_;
    std::size_t counter_sets_ = 0;
};

/// The body for processors: a work-item a core, lanes of samples. Programs::body says which body a device has.
std::unique_ptr<FieldScan> make_bricks_by_vector(const ScanInputs& inputs);
/// Compilers specialise a kernel at its first launch. This launches an empty one and waits for it. Throws cl::Error.
void specialise_bricks_by_vector(device::Context& context, const Programs& programs, const BrickVariant& variant);
/// The body for GPUs: a work-group a brick.
std::unique_ptr<FieldScan> make_bricks_by_group(const ScanInputs& inputs);

}  // namespace clsdf::engine

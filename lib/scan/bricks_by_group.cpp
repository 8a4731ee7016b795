#include "scan/brick_kernel.hpp"

namespace clsdf::scan {

namespace {

// A launch ends within a fifth of a second on a small GPU, for which ten million pairs of a polyhedron and a coarse
// brick a second are assumed. 64 groups test each pair.
constexpr double pairs_per_launch = 2e6;
constexpr std::size_t groups_per_coarse_brick = CLSDF_COARSE_BRICKS;
// Groups that share a coarse brick's list: a narrow band has few coarse bricks, and a GPU many multiprocessors.
constexpr std::size_t mask_groups = 8;

class BricksByGroup final : public BrickKernel {
public:
    BricksByGroup(const ScanInputs& inputs, const CoarseLists& lists, const cl::Buffer& computed)
        : BrickKernel(inputs, lists, pairs_per_launch,
                      inputs.variant.count ? lists.order.size() * groups_per_coarse_brick : 0),
          group_size_(inputs.programs.group_size),
          program_(inputs.programs.bricks(inputs.context, inputs.variant)),
          bounds_(
              inputs.pool->lease(lists.order.size() * groups_per_coarse_brick * sizeof(float), "bounds of the bricks")),
          masks_(inputs.pool->lease(lists.pairs * sizeof(cl_ulong), "masks of the coarse lists' bricks")),
          kernel_(program_, "bricks_by_group") {
        kernel_.setArg(0, inputs.layout);  // 1: enqueue_launch()
        first_output_ =
            set_arguments(kernel_, 2, order_, *lists.starts, static_cast<cl_uint>(lists.parts), *lists.entries,
                          *bounds_, *masks_, *inputs.mesh.polyhedra, inputs.sign_bits, computed);
        enqueue_masks(inputs, lists);
    }

    std::size_t device_bytes() const override { return BrickKernel::device_bytes() + bounds_.bytes() + masks_.bytes(); }

    void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) override {
        set_outputs(kernel_, first_output_, outputs);
        chain.then_fill(*counters_, counter_sets_ * CLSDF_COUNTERS * sizeof(cl_ulong));
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        kernel_.setArg(1, launches_[launch].begin);
        const std::size_t groups = (launches_[launch].end - launches_[launch].begin) * groups_per_coarse_brick;
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueNDRangeKernel(kernel_, cl::NullRange, cl::NDRange(groups * group_size_),
                                       cl::NDRange(group_size_), wait, event);
        });
    }

private:
    /// Enqueues bounds and masks, which the bricks read; once for all computations.
    void enqueue_masks(const ScanInputs& inputs, const CoarseLists& lists) const {
        cl::Kernel bounds(program_, "brick_bounds"), masks(program_, "brick_masks");
        for (const Launch& launch : launches_) {
            const std::size_t items = (launch.end - launch.begin) * group_size_;
            cl_uint next = 0;
            for (cl::Kernel* kernel : {&bounds, &masks})
                next = set_arguments(*kernel, 0, inputs.layout, launch.begin, order_, *lists.starts,
                                     static_cast<cl_uint>(lists.parts), *lists.entries, *lists.bounds,
                                     *inputs.mesh.polyhedra, *bounds_);
            set_arguments(masks, next, static_cast<cl_uint>(mask_groups), *masks_);
            inputs.queue().enqueueNDRangeKernel(bounds, cl::NullRange, cl::NDRange(items), cl::NDRange(group_size_));
            inputs.queue().enqueueNDRangeKernel(masks, cl::NullRange, cl::NDRange(mask_groups * items),
                                                cl::NDRange(group_size_));
        }
    }

    std::size_t group_size_;
    cl::Program program_;
    device::BufferPool::Lease bounds_;  ///< float a brick of the coarse bricks in their order
    device::BufferPool::Lease masks_;   ///< of each entry, the bricks that the polyhedron overlaps
    cl::Kernel kernel_;
    cl_uint first_output_;
};

}  // namespace

std::unique_ptr<BrickKernel> make_bricks_by_group(const ScanInputs& inputs, const CoarseLists& lists,
                                                  const cl::Buffer& computed) {
    return std::make_unique<BricksByGroup>(inputs, lists, computed);
}

}  // namespace clsdf::scan

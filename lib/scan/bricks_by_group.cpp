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
    BricksByGroup(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
                  const BrickInputs& inputs, const BrickVariant& variant)
        : BrickKernel(context, pool, inputs, pairs_per_launch,
                      variant.count ? inputs.lists.order.size() * groups_per_coarse_brick : 0),
          group_size_(programs.group_size),
          program_(programs.bricks(context, variant)),
          bounds_(
              pool->lease(inputs.lists.order.size() * groups_per_coarse_brick * sizeof(float), "bounds of the bricks")),
          masks_(pool->lease(inputs.lists.pairs * sizeof(cl_ulong), "masks of the coarse lists' bricks")),
          kernel_(program_, "bricks_by_group") {
        const CoarseLists& lists = inputs.lists;
        kernel_.setArg(arg_layout, inputs.layout);
        kernel_.setArg(arg_order, order_);
        kernel_.setArg(arg_starts, *lists.starts);
        kernel_.setArg(arg_parts, static_cast<cl_uint>(lists.parts));
        kernel_.setArg(arg_entries, *lists.entries);
        kernel_.setArg(arg_bounds, *bounds_);
        kernel_.setArg(arg_masks, *masks_);
        kernel_.setArg(arg_polyhedra, *inputs.mesh.polyhedra);
        kernel_.setArg(arg_sign_bits, inputs.sign_bits);
        kernel_.setArg(arg_computed, inputs.computed);
        enqueue_masks(context.queue(), inputs);
    }

    std::size_t device_bytes() const override { return BrickKernel::device_bytes() + bounds_.bytes() + masks_.bytes(); }

    void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) override {
        set_outputs(kernel_, arg_distance, outputs);
        chain.then_fill(*counters_, counter_sets_ * CLSDF_COUNTERS * sizeof(cl_ulong));
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        kernel_.setArg(arg_begin, launches_[launch].begin);
        const std::size_t groups = (launches_[launch].end - launches_[launch].begin) * groups_per_coarse_brick;
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueNDRangeKernel(kernel_, cl::NullRange, cl::NDRange(groups * group_size_),
                                       cl::NDRange(group_size_), wait, event);
        });
    }

private:
    /// Enqueues bounds and masks, which the bricks read; once for all computations.
    void enqueue_masks(const cl::CommandQueue& queue, const BrickInputs& inputs) const {
        cl::Kernel bounds(program_, "brick_bounds"), masks(program_, "brick_masks");
        for (cl::Kernel* kernel : {&bounds, &masks}) {
            kernel->setArg(masks_layout, inputs.layout);
            kernel->setArg(masks_order, order_);
            kernel->setArg(masks_starts, *inputs.lists.starts);
            kernel->setArg(masks_parts, static_cast<cl_uint>(inputs.lists.parts));
            kernel->setArg(masks_entries, *inputs.lists.entries);
            kernel->setArg(masks_coarse_bounds, *inputs.lists.bounds);
            kernel->setArg(masks_polyhedra, *inputs.mesh.polyhedra);
            kernel->setArg(masks_bounds, *bounds_);
        }
        masks.setArg(masks_groups, static_cast<cl_uint>(mask_groups));
        masks.setArg(masks_masks, *masks_);
        for (const Launch& launch : launches_) {
            const std::size_t items = (launch.end - launch.begin) * group_size_;
            bounds.setArg(masks_begin, launch.begin);
            masks.setArg(masks_begin, launch.begin);
            queue.enqueueNDRangeKernel(bounds, cl::NullRange, cl::NDRange(items), cl::NDRange(group_size_));
            queue.enqueueNDRangeKernel(masks, cl::NullRange, cl::NDRange(mask_groups * items),
                                       cl::NDRange(group_size_));
        }
    }

    enum MasksArgument : cl_uint {
        masks_layout,
        masks_begin,
        masks_order,
        masks_starts,
        masks_parts,
        masks_entries,
        masks_coarse_bounds,
        masks_polyhedra,
        masks_bounds,
        masks_groups,
        masks_masks
    };
    enum Argument : cl_uint {
        arg_layout,
        arg_begin,
        arg_order,
        arg_starts,
        arg_parts,
        arg_entries,
        arg_bounds,
        arg_masks,
        arg_polyhedra,
        arg_sign_bits,
        arg_computed,
        arg_distance  // and what set_outputs() sets
    };

    std::size_t group_size_;
    cl::Program program_;
    device::BufferPool::Lease bounds_;  ///< float a brick of the coarse bricks in their order
    device::BufferPool::Lease masks_;   ///< of each entry, the bricks that the polyhedron overlaps
    cl::Kernel kernel_;
};

}  // namespace

std::unique_ptr<BrickKernel> make_bricks_by_group(device::Context& context, const Programs& programs,
                                                  const std::shared_ptr<device::BufferPool>& pool,
                                                  const BrickInputs& inputs, const BrickVariant& variant) {
    return std::make_unique<BricksByGroup>(context, programs, pool, inputs, variant);
}

}  // namespace clsdf::scan

#include "scan/brick_kernel.hpp"

#include <algorithm>

namespace clsdf::scan {

namespace {

// A launch ends within a fifth of a second, so that a computation can be stopped: a pair of a polyhedron and a coarse
// brick takes at most a microsecond. But one core computes a coarse brick, however long its list is.
constexpr double pairs_per_core_and_launch = 100000;

/// The minima of a coarse brick, whose bricks a work-item takes together.
std::size_t minima_bytes(const BrickVariant& variant) {
    constexpr std::size_t bricks = CLSDF_BRICKS_PER_COARSE * CLSDF_BRICKS_PER_COARSE * CLSDF_BRICKS_PER_COARSE;
    return bricks * CLSDF_MINIMUM_BYTES(variant.nearest);
}

/// One a core, as far as their minima fit into one allocation.
std::size_t work_items(const device::Context& context, const BrickVariant& variant) {
    const device::Context::Capabilities& capabilities = context.capabilities();
    return std::clamp<std::size_t>(capabilities.largest_allocation / minima_bytes(variant), 1,
                                   capabilities.compute_units);
}

class BricksByVector final : public BrickKernel {
public:
    BricksByVector(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
                   const BrickInputs& inputs, const BrickVariant& variant)
        : BrickKernel(context, pool, inputs,
                      pairs_per_core_and_launch * static_cast<double>(work_items(context, variant)),
                      variant.count ? work_items(context, variant) : 0),
          work_items_(work_items(context, variant)),
          kernel_(programs.bricks(context, variant), "bricks_by_vector") {
        const CoarseLists& lists = inputs.lists;
        next_slots_ = pool->lease(launches_.size() * sizeof(cl_uint), "next slots of the launches");
        scratch_ = pool->lease(work_items_ * std::size_t{CLSDF_SCRATCH_BYTES}, "scratch of the bricks");
        minima_ = pool->lease(work_items_ * minima_bytes(variant), "minima of the bricks");

        kernel_.setArg(arg_layout, inputs.layout);
        kernel_.setArg(arg_next_slot, *next_slots_);
        kernel_.setArg(arg_order, order_);
        kernel_.setArg(arg_starts, *lists.starts);
        kernel_.setArg(arg_parts, static_cast<cl_uint>(lists.parts));
        kernel_.setArg(arg_entries, *lists.entries);
        kernel_.setArg(arg_bounds, *lists.bounds);
        kernel_.setArg(arg_polyhedra, *inputs.mesh.polyhedra);
        kernel_.setArg(arg_sign_bits, inputs.sign_bits);
        kernel_.setArg(arg_computed, inputs.computed);
        kernel_.setArg(arg_scratch, *scratch_);
        kernel_.setArg(arg_minima, *minima_);
        if (!launches_.empty() && context.is_first_use_of(kernel_)) warm_up(context.queue(), inputs.computed);
    }

    void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) override {
        set_outputs(kernel_, arg_distance, outputs);
        chain.then_fill(*counters_, counter_sets_ * CLSDF_COUNTERS * sizeof(cl_ulong));
        chain.then_fill(*next_slots_, launches_.size() * sizeof(cl_uint));
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        kernel_.setArg(arg_launch, static_cast<cl_uint>(launch));
        kernel_.setArg(arg_begin, launches_[launch].begin);
        kernel_.setArg(arg_end, launches_[launch].end);
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueNDRangeKernel(kernel_, cl::NullRange, cl::NDRange(work_items_), cl::NDRange(1), wait, event);
        });
    }

    std::size_t device_bytes() const override {
        return BrickKernel::device_bytes() + next_slots_.bytes() + scratch_.bytes() + minima_.bytes();
    }

private:
    enum Argument : cl_uint {
        arg_layout,
        arg_launch,
        arg_begin,
        arg_end,
        arg_next_slot,
        arg_order,
        arg_starts,
        arg_parts,
        arg_entries,
        arg_bounds,
        arg_polyhedra,
        arg_sign_bits,
        arg_computed,
        arg_scratch,
        arg_minima,
        arg_distance  // and what set_outputs() sets
    };

    void warm_up(const cl::CommandQueue& queue, const cl::Buffer& unused) {
        kernel_.setArg(arg_launch, cl_uint{0});
        kernel_.setArg(arg_begin, cl_uint{0});
        kernel_.setArg(arg_end, cl_uint{0});
        OutputBuffers outputs;
        outputs.distance = unused;
        set_outputs(kernel_, arg_distance, outputs);
        queue.enqueueNDRangeKernel(kernel_, cl::NullRange, cl::NDRange(work_items_), cl::NDRange(1));
        queue.finish();
    }

    std::size_t work_items_;
    cl::Kernel kernel_;
    device::BufferPool::Lease next_slots_;
    device::BufferPool::Lease scratch_;
    device::BufferPool::Lease minima_;
};

}  // namespace

std::unique_ptr<BrickKernel> make_bricks_by_vector(device::Context& context, const Programs& programs,
                                                   const std::shared_ptr<device::BufferPool>& pool,
                                                   const BrickInputs& inputs, const BrickVariant& variant) {
    return std::make_unique<BricksByVector>(context, programs, pool, inputs, variant);
}

}  // namespace clsdf::scan

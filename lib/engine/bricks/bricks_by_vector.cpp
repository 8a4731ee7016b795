#include "bricks/brick_scan.hpp"
#include "device/buffer_pool.hpp"

#include <algorithm>

namespace clsdf::engine {

namespace {

// A launch ends within a fifth of a second, so that a computation can be stopped: a pair of a polyhedron and a coarse
// brick takes at most a microsecond, a coarse brick 300 to 400 beside its pairs. But one core computes a coarse brick,
// however long its list is.
constexpr double pairs_per_core_and_launch = 100000, pairs_of_a_brick = 300;

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

class BricksByVector final : public BrickScan {
public:
    BricksByVector(const ScanInputs& inputs)
        : BricksByVector(inputs, work_items(inputs.tools.context, inputs.variant)) {}

    void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) override {
        set_outputs(kernel_, first_output_, outputs);
        chain.then_fill(*next_slots_, launches_.size() * sizeof(cl_uint));
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        set_launch(launch, launches_[launch].begin, launches_[launch].end);
        chain.then_launch(kernel_, {work_items_, 1});
    }

    void describe(CallStatistics& statistics) const override {
        BrickScan::describe(statistics);
        statistics.device_bytes += next_slots_.bytes() + scratch_.bytes() + minima_.bytes();
    }

private:
    BricksByVector(const ScanInputs& inputs, std::size_t work_items)
        : BrickScan(inputs, {pairs_per_core_and_launch * static_cast<double>(work_items), pairs_of_a_brick}),
          work_items_(work_items),
          kernel_(inputs.tools.kernel(inputs.tools.programs.bricks(inputs.tools.context, inputs.variant),
                                      "bricks_by_vector")),
          next_slots_(
              inputs.tools.pool->lease_for_list(launches_.size() * sizeof(cl_uint), "next slots of the launches")),
          scratch_(inputs.tools.pool->lease(work_items_ * std::size_t{CLSDF_SCRATCH_BYTES}, "scratch of the bricks")),
          minima_(inputs.tools.pool->lease(work_items_ * minima_bytes(inputs.variant), "minima of the bricks")) {
        make_counters(inputs, work_items_);
        kernel_.setArg(0, inputs.layout);  // 1 to 3: set_launch()
        first_output_ = set_arguments(kernel_, 4, *next_slots_, *order_, *lists_.starts,
                                      static_cast<cl_uint>(lists_.parts), *lists_.entries, *lists_.bounds,
                                      *inputs.mesh.polyhedra, inputs.sign_bits, *computed_, *scratch_, *minima_);
    }

    void set_launch(std::size_t launch, cl_uint begin, cl_uint end) {
        set_arguments(kernel_, 1, static_cast<cl_uint>(launch), begin, end);
    }

    std::size_t work_items_;
    device::LentKernel kernel_;
    device::BufferPool::Lease next_slots_;
    device::BufferPool::Lease scratch_;
    device::BufferPool::Lease minima_;
    cl_uint first_output_;
};

}  // namespace

void specialise_bricks_by_vector(device::Context& context, const Programs& programs, const BrickVariant& variant) {
    device::LentKernel kernel(context.kernels(), programs.bricks(context, variant), "bricks_by_vector");
    // The kernel writes only the counter of the slots and the minima. It computes nothing, whatever they hold.
    const cl::Buffer array(context.context(), CL_MEM_READ_WRITE, minima_bytes(variant));
    const cl_uint none = 0;
    cl_uint next = set_arguments(kernel, 0, Layout{}, none, none, none, array, array, array, none);
    const std::size_t arguments = kernel.getInfo<CL_KERNEL_NUM_ARGS>();
    const cl_uint finish = next + 9;  // after the lists, the mesh, the signs, marks, the scratch, bricks, the distance
    for (; next < arguments; ++next)
        if (variant.nearest && next == finish)
            kernel.setArg(next, Finish{});
        else
            kernel.setArg(next, array);
    launch(context.queue(), kernel, {1, 1});
    context.finish();
}

std::unique_ptr<FieldScan> make_bricks_by_vector(const ScanInputs& inputs) {
    return std::make_unique<BricksByVector>(inputs);
}

}  // namespace clsdf::engine

#include "scan/brick_kernel.hpp"

#include "device/buffer_pool.hpp"

#include <algorithm>

namespace clsdf::scan {

namespace {

// In a launch. Each has 64 groups of 128 work-items, and some drivers count work-items in 32 bits.
constexpr cl_uint most_coarse_bricks = 1U << 17;

}  // namespace

BrickKernel::BrickKernel(const ScanInputs& inputs, const CoarseLists& lists, double pairs_per_launch,
                         std::size_t counter_sets)
    : finishing_(inputs.finishing), counter_sets_(counter_sets) {
    double before = 0;
    double pairs = 0;
    cl_uint begin = 0;
    const auto count = static_cast<cl_uint>(lists.order.size());
    for (cl_uint i = 0; i < count; ++i) {
        pairs += lists.lengths[i];
        if (pairs < pairs_per_launch && i + 1 - begin < most_coarse_bricks && i + 1 < count) continue;
        launches_.push_back({begin, i + 1, before / static_cast<double>(lists.pairs)});
        before += pairs;
        pairs = 0;
        begin = i + 1;
    }
    if (!lists.order.empty()) order_ = device::copied(inputs.context, lists.order);
    if (counter_sets > 0) counters_ = inputs.pool->lease(counter_sets * CLSDF_COUNTERS * sizeof(cl_ulong), "counters");
}

void BrickKernel::set_outputs(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const {
    cl_uint next = set_arguments(kernel, first, outputs[Output::distance]);
    if (finishing_ != nullptr) next = finishing_->set_arguments(kernel, next, outputs);
    if (counter_sets_ > 0) kernel.setArg(next, *counters_);
}

std::vector<std::size_t> BrickKernel::read_counters(const cl::CommandQueue& queue) const {
    if (counter_sets_ == 0) return {};
    std::vector<cl_ulong> sets(counter_sets_ * CLSDF_COUNTERS);
    queue.enqueueReadBuffer(*counters_, CL_TRUE, 0, sets.size() * sizeof(cl_ulong), sets.data());
    std::vector<std::size_t> sums(CLSDF_COUNTERS);
    for (std::size_t i = 0; i < sets.size(); ++i) sums[i % CLSDF_COUNTERS] += sets[i];
    return sums;
}

// The body for processors.
// ----------------------------------------------------------------------------------------------

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
    BricksByVector(const ScanInputs& inputs, const CoarseLists& lists, const cl::Buffer& computed)
        : BricksByVector(inputs, lists, computed, work_items(inputs.context, inputs.variant)) {}

    void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) override {
        set_outputs(kernel_, first_output_, outputs);
        chain.then_fill(*counters_, counter_sets_ * CLSDF_COUNTERS * sizeof(cl_ulong));
        chain.then_fill(*next_slots_, launches_.size() * sizeof(cl_uint));
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        set_launch(launch, launches_[launch].begin, launches_[launch].end);
        chain.then_launch(kernel_, {work_items_, 1});
    }

    std::size_t device_bytes() const override {
        return BrickKernel::device_bytes() + next_slots_.bytes() + scratch_.bytes() + minima_.bytes();
    }

private:
    BricksByVector(const ScanInputs& inputs, const CoarseLists& lists, const cl::Buffer& computed,
                   std::size_t work_items)
        : BrickKernel(inputs, lists, pairs_per_core_and_launch * static_cast<double>(work_items),
                      inputs.variant.count ? work_items : 0),
          work_items_(work_items),
          kernel_(inputs.programs.bricks(inputs.context, inputs.variant), "bricks_by_vector"),
          next_slots_(inputs.pool->lease_for_list(launches_.size() * sizeof(cl_uint), "next slots of the launches")),
          scratch_(inputs.pool->lease(work_items_ * std::size_t{CLSDF_SCRATCH_BYTES}, "scratch of the bricks")),
          minima_(inputs.pool->lease(work_items_ * minima_bytes(inputs.variant), "minima of the bricks")) {
        kernel_.setArg(0, inputs.layout);  // 1 to 3: set_launch()
        first_output_ = set_arguments(kernel_, 4, *next_slots_, order_, *lists.starts,
                                      static_cast<cl_uint>(lists.parts), *lists.entries, *lists.bounds,
                                      *inputs.mesh.polyhedra, inputs.sign_bits, computed, *scratch_, *minima_);
        if (!launches_.empty() && inputs.context.is_first_use_of(kernel_)) warm_up(inputs.queue(), computed);
    }

    void set_launch(std::size_t launch, cl_uint begin, cl_uint end) {
        set_arguments(kernel_, 1, static_cast<cl_uint>(launch), begin, end);
    }

    void warm_up(const cl::CommandQueue& queue, const cl::Buffer& unused) {
        set_launch(0, 0, 0);
        OutputBuffers outputs;
        outputs[Output::distance] = unused;
        set_outputs(kernel_, first_output_, outputs);
        scan::launch(queue, kernel_, {work_items_, 1});
        queue.finish();
    }

    std::size_t work_items_;
    cl::Kernel kernel_;
    device::BufferPool::Lease next_slots_;
    device::BufferPool::Lease scratch_;
    device::BufferPool::Lease minima_;
    cl_uint first_output_;
};

}  // namespace

std::unique_ptr<BrickKernel> make_bricks_by_vector(const ScanInputs& inputs, const CoarseLists& lists,
                                                   const cl::Buffer& computed) {
    return std::make_unique<BricksByVector>(inputs, lists, computed);
}

// The body for GPUs.
// ----------------------------------------------------------------------------------------------------

namespace {

// A launch ends within a fifth of a second on a small GPU, for which ten million pairs of a polyhedron and a coarse
// brick a second are assumed. 64 groups test each pair.
constexpr double pairs_per_group_launch = 2e6;
constexpr std::size_t groups_per_coarse_brick = CLSDF_COARSE_BRICKS;
// Groups that share a coarse brick's list: a narrow band has few coarse bricks, and a GPU many multiprocessors.
constexpr std::size_t mask_groups = 8;

class BricksByGroup final : public BrickKernel {
public:
    BricksByGroup(const ScanInputs& inputs, const CoarseLists& lists, const cl::Buffer& computed)
        : BrickKernel(inputs, lists, pairs_per_group_launch,
                      inputs.variant.count ? lists.order.size() * groups_per_coarse_brick : 0),
          group_size_(inputs.programs.group_size),
          program_(inputs.programs.bricks(inputs.context, inputs.variant)),
          bounds_(inputs.pool->lease_for_list(lists.order.size() * groups_per_coarse_brick * sizeof(float),
                                              "bounds of the bricks")),
          masks_(inputs.pool->lease_for_list(lists.pairs * sizeof(cl_ulong), "masks of the coarse lists' bricks")),
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
        chain.then_launch(kernel_, {groups * group_size_, group_size_});
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
            scan::launch(inputs.queue(), bounds, {items, group_size_});
            scan::launch(inputs.queue(), masks, {mask_groups * items, group_size_});
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

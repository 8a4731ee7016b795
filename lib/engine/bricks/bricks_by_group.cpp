#include "bricks/brick_scan.hpp"
#include "device/buffer_pool.hpp"

#include <algorithm>

namespace clsdf::engine {

namespace {

// A launch ends within a fifth of a second on a small GPU, for which ten million pairs of a polyhedron and a coarse
// brick a second are assumed. 64 groups test each pair.
constexpr double pairs_per_group_launch = 2e6;
constexpr std::size_t groups_per_coarse_brick = CLSDF_COARSE_BRICKS;
// Groups that share a coarse brick's list: there may be few coarse bricks, and a GPU has many multiprocessors. Each
// work-item has about two entries of the longest list.
constexpr std::size_t most_list_groups = 64, entries_of_an_item = 2;

class BricksByGroup final : public BrickScan {
public:
    BricksByGroup(const ScanInputs& inputs)
        : BrickScan(inputs, {pairs_per_group_launch}),
          group_size_(inputs.tools.programs.group_size),
          program_(inputs.tools.programs.bricks(inputs.tools.context, inputs.variant)),
          bounds_(inputs.tools.pool->lease_for_list(lists_.order.size() * groups_per_coarse_brick * sizeof(float),
                                                    "bounds of the bricks")),
          masks_(
              inputs.tools.pool->lease_for_list(lists_.pairs * sizeof(cl_ulong), "masks of the coarse lists' bricks")),
          kernel_(inputs.tools.kernel(program_, "bricks_by_group")) {
        make_counters(inputs, lists_.order.size() * groups_per_coarse_brick);
        kernel_.setArg(0, inputs.layout);  // 1: enqueue_launch()
        first_output_ =
            set_arguments(kernel_, 2, *order_, *lists_.starts, static_cast<cl_uint>(lists_.parts), *lists_.entries,
                          *bounds_, *masks_, *inputs.mesh.polyhedra, inputs.sign_bits, *computed_);
        enqueue_masks(inputs);
    }

    void describe(CallStatistics& statistics) const override {
        BrickScan::describe(statistics);
        statistics.device_bytes += bounds_.bytes() + masks_.bytes();
    }

    void enqueue_reset(CommandChain&, const OutputBuffers& outputs) override {
        set_outputs(kernel_, first_output_, outputs);
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        kernel_.setArg(1, launches_[launch].begin);
        const std::size_t groups = (launches_[launch].end - launches_[launch].begin) * groups_per_coarse_brick;
        chain.then_launch(kernel_, {groups * group_size_, group_size_});
    }

private:
    /// Enqueues bounds and masks, which the bricks read; once for all computations.
    void enqueue_masks(const ScanInputs& inputs) const {
        if (lists_.order.empty()) return;
        const std::size_t longest = std::ranges::max(lists_.lengths);
        const auto groups = std::clamp<std::size_t>(longest / (entries_of_an_item * group_size_), 1, most_list_groups);
        constexpr cl_uint infinity = 0x7F800000U;
        inputs.tools.queue().enqueueFillBuffer(*bounds_, infinity, 0,
                                               lists_.order.size() * groups_per_coarse_brick * sizeof(float));
        device::LentKernel bounds = inputs.tools.kernel(program_, "brick_bounds"),
                           masks = inputs.tools.kernel(program_, "brick_masks");
        for (const BrickLaunch& launch : launches_of(lists_, {pairs_per_group_launch})) {
            const std::size_t items = (launch.end - launch.begin) * groups * group_size_;
            cl_uint next = 0;
            for (device::LentKernel* kernel : {&bounds, &masks})
                next = set_arguments(*kernel, 0, inputs.layout, launch.begin, *order_, *lists_.starts,
                                     static_cast<cl_uint>(lists_.parts), *lists_.entries, *lists_.bounds,
                                     *inputs.mesh.polyhedra, *bounds_, static_cast<cl_uint>(groups));
            set_arguments(masks, next, *masks_);
            engine::launch(inputs.tools.queue(), bounds, {items, group_size_});
            engine::launch(inputs.tools.queue(), masks, {items, group_size_});
        }
    }

    std::size_t group_size_;
    cl::Program program_;
    device::BufferPool::Lease bounds_;  ///< float a brick of the coarse bricks in their order
    device::BufferPool::Lease masks_;   ///< of each entry, the bricks that the polyhedron overlaps
    device::LentKernel kernel_;
    cl_uint first_output_;
};

}  // namespace

std::unique_ptr<FieldScan> make_bricks_by_group(const ScanInputs& inputs) {
    return std::make_unique<BricksByGroup>(inputs);
}

}  // namespace clsdf::engine

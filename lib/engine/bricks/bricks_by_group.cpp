#include "bricks/brick_scan.hpp"
#include "device/buffer_pool.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

// A launch ends within a fifth of a second on a small GPU, for which ten million pairs of a polyhedron and a coarse
// brick a second are assumed. 64 groups test each pair.
constexpr double pairs_per_group_launch = 2e6;
constexpr std::size_t groups_per_coarse_brick = CLSDF_COARSE_BRICKS;
// Groups that share a coarse brick's list: there may be few coarse bricks, and a GPU has many multiprocessors. Each
// work-item has about two entries of the longest list.
constexpr std::size_t most_list_groups = 64, entries_of_an_item = 2;
constexpr cl_uint most_shares = 8;

/// How groups share the list of a brick. It changes no result: it decides which polyhedra a bound excludes, and a bound
/// excludes only those that are farther.
struct Sharing {
    cl_uint window;         ///< see BrickTask
    cl_uint share_entries;  ///< each share has so many at least
    cl_uint room;           ///< for sets of minima; lists are not shared if it is less than most_shares
};

/// Of the minima that shares store at a time.
std::size_t most_minima_bytes(const device::Context& context) {
    const device::Context::Capabilities& capabilities = context.capabilities();
    return std::min({capabilities.largest_allocation, capabilities.memory / 16, std::size_t{64} << 20});
}

/// The tasks [begin, joins) of a launch, and those of a second one, [joins, end), which join the minima of shares.
struct TaskRange {
    std::size_t begin, joins, end;
};
struct BrickTasks {
    std::vector<BrickTask> tasks;
    std::vector<std::vector<TaskRange>> ranges;  ///< of each launch of the scan
    cl_uint minima = 0;                          ///< sets of minima, of the shares of a range
};

BrickTasks tasks_of(const CoarseLists& lists, const std::vector<BrickLaunch>& launches, const Sharing& sharing) {
    BrickTasks all;
    std::vector<BrickTask> joins;
    const auto end_range = [&](std::size_t begin) {
        const std::size_t first_join = all.tasks.size();
        all.tasks.insert(all.tasks.end(), joins.begin(), joins.end());
        joins.clear();
        all.ranges.back().push_back({begin, first_join, all.tasks.size()});
    };
    for (const BrickLaunch& launch : launches) {
        all.ranges.emplace_back();
        std::size_t begin = all.tasks.size();
        cl_uint minima = 0;
        for (cl_uint slot = launch.begin; slot < launch.end; ++slot) {
            const cl_uint most = sharing.room < most_shares ? 1 : most_shares;
            const cl_uint shares = std::clamp(lists.lengths[slot] / sharing.share_entries, 1U, most);
            if (shares > 1 && minima + shares > sharing.room) {
                end_range(begin);
                begin = all.tasks.size();
                minima = 0;
            }
            for (cl_uint share = 0; share < shares; ++share)
                all.tasks.push_back({slot, shares, share, minima, sharing.window});
            if (shares == 1) continue;
            joins.push_back({slot, shares, shares, minima, sharing.window});
            minima += shares;
            all.minima = std::max(all.minima, minima);
        }
        end_range(begin);
    }
    return all;
}

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
        const std::size_t set_bytes = groups_per_coarse_brick * CLSDF_MINIMUM_BYTES(inputs.variant.nearest);
        const auto room = static_cast<cl_uint>(most_minima_bytes(inputs.tools.context) / set_bytes);
        const auto window = static_cast<cl_uint>(CLSDF_WINDOW(group_size_));
        BrickTasks tasks =
            tasks_of(lists_, launches_, inputs.shares_short_lists ? Sharing{4, 4, room} : Sharing{window, 2048, room});
        ranges_ = std::move(tasks.ranges);
        if (!tasks.tasks.empty())
            tasks_ = device::copied(inputs.tools.context, inputs.tools.pool, tasks.tasks, "tasks of the bricks");
        minima_ = inputs.tools.pool->lease_for_list(tasks.minima * set_bytes, "minima of the lists' shares");
        make_counters(inputs, tasks.tasks.size() * groups_per_coarse_brick);
        kernel_.setArg(0, inputs.layout);  // 1: enqueue_tasks()
        first_output_ =
            set_arguments(kernel_, 2, *tasks_, *minima_, *order_, *lists_.starts, static_cast<cl_uint>(lists_.parts),
                          *lists_.entries, *bounds_, *masks_, *inputs.mesh.polyhedra, inputs.sign_bits, *computed_);
        enqueue_masks(inputs);
    }

    void describe(CallStatistics& statistics) const override {
        BrickScan::describe(statistics);
        statistics.device_bytes += bounds_.bytes() + masks_.bytes() + tasks_.bytes() + minima_.bytes();
    }

    void enqueue_reset(CommandChain&, const OutputBuffers& outputs) override {
        set_outputs(kernel_, first_output_, outputs);
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        for (const TaskRange& range : ranges_[launch]) {
            enqueue_tasks(chain, range.begin, range.joins);
            enqueue_tasks(chain, range.joins, range.end);
        }
    }

private:
    void enqueue_tasks(CommandChain& chain, std::size_t begin, std::size_t end) {
        if (begin == end) return;
        kernel_.setArg(1, static_cast<cl_uint>(begin));
        chain.then_launch(kernel_, {(end - begin) * groups_per_coarse_brick * group_size_, group_size_});
    }

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
    device::BufferPool::Lease bounds_;            ///< float a brick of the coarse bricks in their order
    device::BufferPool::Lease masks_;             ///< of each entry, the bricks that the polyhedron overlaps
    std::vector<std::vector<TaskRange>> ranges_;  ///< of the tasks, by launch
    device::BufferPool::Lease tasks_;
    device::BufferPool::Lease minima_;  ///< of the shares of a range
    device::LentKernel kernel_;
    cl_uint first_output_;
};

}  // namespace

std::unique_ptr<FieldScan> make_bricks_by_group(const ScanInputs& inputs) {
    return std::make_unique<BricksByGroup>(inputs);
}

}  // namespace clsdf::engine

#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "scan/brick_kernel.hpp"
#include "scan/coarse_lists.hpp"
#include "scan/layout_of.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

namespace clsdf::scan {

namespace {

constexpr double seconds_per_filled_sample = 1e-9;  // of a core, rounded up

// On a processor. PoCL compiles a kernel anew for each size of a group: one size for nearly all grids, and another one
// where so many slices would take too long.
constexpr std::size_t slices_of_a_group = 32;

/// A value as the fill kernel stores it: a double, or two floats.
cl_ulong pattern_of(double value) {
    return std::bit_cast<cl_ulong>(value);
}
cl_ulong pattern_of(float value) {
    return std::bit_cast<cl_ulong>(std::array{value, value});
}

/// On a GPU: as many as there are bricks in a row, up to a power of two.
std::size_t pieces_of_a_group(const Layout& layout) {
    return std::min(std::bit_ceil(static_cast<std::size_t>(layout.bricks[0])), common_group);
}

/// The first marks of a part's bricks: 0 for those that overlap wanted blocks of the lattice.
std::vector<cl_uchar> marks_of(const Layout& layout, std::span<const Grid> wanted) {
    std::vector<cl_uchar> marks(brick_count(layout), CLSDF_UNWANTED_BRICK);
    for (const Grid& block : wanted) {
        const Layout of_block = bricks_of(block);
        std::array<std::int32_t, 3> begin{}, end{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int32_t first = of_block.brick_first[axis] - layout.brick_first[axis];
            begin[axis] = std::max(first, 0);
            end[axis] = std::min(first + of_block.bricks[axis], layout.bricks[axis]);
        }
        for (std::int32_t z = begin[2]; z < end[2]; ++z)
            for (std::int32_t y = begin[1]; y < end[1]; ++y) {
                const auto row = marks.begin() + (std::ptrdiff_t{z} * layout.bricks[1] + y) * layout.bricks[0];
                if (begin[0] < end[0]) std::fill(row + begin[0], row + end[0], cl_uchar{0});
            }
    }
    return marks;
}

class BrickScan final : public FieldScan {
public:
    explicit BrickScan(const ScanInputs& inputs)
        : layout_(inputs.layout),
          // A processor stores long runs; neighbouring work-items of a GPU should store beside each other.
          fill_group_pieces_(is_by_group(inputs) ? pieces_of_a_group(layout_) : 1),
          fill_group_slices_(is_by_group(inputs) ? common_group / fill_group_pieces_ : slices_of_a_group),
          fill_pieces_(is_by_group(inputs)
                           ? in_whole_groups(static_cast<std::size_t>(layout_.bricks[0]), fill_group_pieces_)
                           : 1),
          lists_(make_coarse_lists(inputs)),
          computed_(inputs.pool->lease(brick_count(layout_), "marks of the computed bricks")) {
        if (!inputs.wanted.empty()) first_marks_ = device::copied(inputs.context, marks_of(layout_, inputs.wanted));
        const auto make = is_by_group(inputs) ? make_bricks_by_group : make_bricks_by_vector;
        bricks_ = make(inputs, lists_, *computed_);
        fill_kernel_ = cl::Kernel(inputs.programs.fill, "fill_empty_bricks");
        fill_outputs_ = set_arguments(fill_kernel_, 0, layout_, *computed_, inputs.sign_bits);
        finishing_ = inputs.finishing;
        leave_kernel_ = cl::Kernel(inputs.programs.fill, "leave_empty_bricks");
        leave_outputs_ = set_arguments(leave_kernel_, 0, layout_, *computed_);
        const double slice = static_cast<double>(layout_.size[0]) * static_cast<double>(layout_.size[1]);
        const std::size_t most_slices = inputs.launches.most(seconds_per_filled_sample * slice);
        if (most_slices < fill_group_slices_) fill_group_slices_ = 1;
        slices_per_fill_ = most_slices / fill_group_slices_ * fill_group_slices_;
    }

    std::size_t launch_count() const override { return bricks_->launch_count(); }
    double fraction_before(std::size_t launch) const override { return bricks_->fraction_before(launch); }

    void enqueue_begin(CommandChain& chain, const OutputBuffers& outputs) override {
        if (first_marks_() == nullptr)
            chain.then_fill(*computed_, brick_count(layout_));
        else
            chain.then([&](auto& queue, auto* wait, auto* event) {
                queue.enqueueCopyBuffer(first_marks_, *computed_, 0, 0, brick_count(layout_), wait, event);
            });
        bricks_->enqueue_reset(chain, outputs);
        outputs_ = outputs;
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override { bricks_->enqueue_launch(chain, launch); }

    void enqueue_end(CommandChain& chain) override {
        const bool in_double = (outputs_.in_double & OutputSet(Output::distance).bits()) != 0;
        const cl_int words = in_double ? 2 : 1;
        const auto [inside, outside] =
            in_double ? std::pair(pattern_of(finishing_->inside_fill()), pattern_of(finishing_->outside_fill()))
                      : std::pair(pattern_of(layout_.inside_fill), pattern_of(layout_.outside_fill));
        enqueue_slices(chain, fill_kernel_,
                       set_arguments(fill_kernel_, fill_outputs_, outputs_[Output::distance], words, inside, outside),
                       in_groups(slices_per_fill_ / static_cast<std::size_t>(words)));
        for_each_extra(
            [&](const OutputInfo& row, const cl::Buffer& buffer) {
                if (buffer() == nullptr) return;
                const std::size_t bytes = sample_bytes(row, (outputs_.in_double & bit_of(row)) != 0);
                enqueue_slices(chain, leave_kernel_,
                               set_arguments(leave_kernel_, leave_outputs_, buffer, static_cast<cl_int>(bytes)),
                               in_groups(slices_per_fill_ * sizeof(float) / std::max(bytes, sizeof(float))));
            },
            outputs_);
        outputs_ = {};
    }

    void describe(CallStatistics& statistics) const override {
        statistics.coarse_pairs = lists_.pairs;
        statistics.coarse_bricks = lists_.order.size();
        if (first_marks_() != nullptr) statistics.device_bytes += computed_.bytes();
        statistics.device_bytes += bricks_->device_bytes() + lists_.bounds.bytes() + lists_.starts.bytes() +
                                   lists_.entries.bytes() + lists_.order.size() * sizeof(cl_uint) + computed_.bytes();
    }

    void read_counters(const cl::CommandQueue& queue, CallStatistics& statistics) const override {
        const std::vector<std::size_t> counters = bricks_->read_counters(queue);
        if (counters.empty()) return;
        statistics.brick_pairs = counters[CLSDF_COUNT_BRICK_PAIRS];
        statistics.lanes_evaluated = counters[CLSDF_COUNT_LANES];
        statistics.samples_covered = counters[CLSDF_COUNT_COVERED];
        statistics.band_samples = counters[CLSDF_COUNT_BAND];
    }

private:
    static bool is_by_group(const ScanInputs& inputs) { return inputs.programs.body == KernelBody::by_group; }

    /// Enqueues all slices of the empty bricks, in whole groups, at most `most` slices a launch. The kernel's argument
    /// `last_argument` is a launch's first slice.
    void enqueue_slices(CommandChain& chain, cl::Kernel& kernel, cl_uint last_argument, std::size_t most) const {
        const auto brick_rows = static_cast<std::size_t>(layout_.bricks[1]);
        // The kernel skips slices beyond the last one.
        const std::size_t slices = in_whole_groups(static_cast<std::size_t>(layout_.size[2]), fill_group_slices_);
        const cl::NDRange group(fill_group_pieces_, 1, fill_group_slices_);
        divided({fill_pieces_, brick_rows, slices}, {most_groups, std::min(most, most_groups * fill_group_slices_)},
                [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                    // An argument: PoCL compiles a kernel once more for offsets that are not 0.
                    kernel.setArg(last_argument, static_cast<cl_int>(z));
                    chain.then([&](auto& target, auto* wait, auto* event) {
                        target.enqueueNDRangeKernel(kernel, cl::NDRange(0, y, 0), items, group, wait, event);
                    });
                });
    }

    /// Whole groups of no more slices, but one at least.
    std::size_t in_groups(std::size_t slices) const {
        return std::max<std::size_t>(slices / fill_group_slices_, 1) * fill_group_slices_;
    }

    Layout layout_;
    std::size_t fill_group_pieces_;
    std::size_t fill_group_slices_;
    std::size_t fill_pieces_;  ///< of a row of bricks, a work-item each
    CoarseLists lists_;
    device::BufferPool::Lease computed_;
    cl::Buffer first_marks_;  ///< of the bricks; null: all 0
    std::unique_ptr<BrickKernel> bricks_;
    cl::Kernel fill_kernel_;
    cl::Kernel leave_kernel_;
    const Finishing* finishing_;  ///< null if only floats are written
    cl_uint fill_outputs_;        ///< the kernels' first arguments that change from call to call
    cl_uint leave_outputs_;
    OutputBuffers outputs_;  ///< of the computation that is being enqueued
    std::size_t slices_per_fill_;
};

}  // namespace

std::unique_ptr<FieldScan> make_brick_scan(const ScanInputs& inputs) {
    return std::make_unique<BrickScan>(inputs);
}

}  // namespace clsdf::scan

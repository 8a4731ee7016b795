#include "bricks/brick_scan.hpp"

#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "device/read_back.hpp"
#include "lattice/layout_of.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>
#include <utility>
#include <vector>

namespace clsdf::engine {

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

bool is_by_group(const ScanInputs& inputs) {
    return inputs.tools.programs.body == KernelBody::by_group;
}

// In a launch. Each has 64 groups of 128 work-items, and some drivers count work-items in 32 bits.
constexpr cl_uint most_coarse_bricks = 1U << 17;

}  // namespace

std::vector<BrickLaunch> launches_of(const CoarseLists& lists, const LaunchWork& most, cl_uint upper_begin) {
    std::vector<BrickLaunch> launches;
    double before = 0, pairs = 0;
    cl_uint begin = 0;
    const auto count = static_cast<cl_uint>(lists.order.size());
    const double all = static_cast<double>(lists.pairs) + most.pairs_of_a_brick * static_cast<double>(count);
    for (cl_uint i = 0; i < count; ++i) {
        pairs += lists.lengths[i] + most.pairs_of_a_brick;
        const bool is_last = i + 1 == count || i + 1 == upper_begin;
        if (pairs < most.pairs && i + 1 - begin < most_coarse_bricks && !is_last) continue;
        launches.push_back({begin, i + 1, before / all});
        before += pairs;
        pairs = 0;
        begin = i + 1;
    }
    return launches;
}

BrickScan::BrickScan(const ScanInputs& inputs, const LaunchWork& most)
    : lists_(make_coarse_lists(
          {inputs.tools, inputs.layout, inputs.mesh, inputs.launches, inputs.selection, inputs.points})),
      launches_(launches_of(lists_, most)),
      computed_(inputs.tools.pool->lease(brick_count(inputs.layout), "marks of the computed bricks")),
      layout_(inputs.layout),
      bricks_(brick_count(layout_)),
      // A processor stores long runs; neighbouring work-items of a GPU should store beside each other.
      fill_group_pieces_(is_by_group(inputs) ? pieces_of_a_group(layout_) : 1),
      fill_group_slices_(is_by_group(inputs) ? common_group / fill_group_pieces_ : slices_of_a_group),
      fill_pieces_(
          is_by_group(inputs) ? in_whole_groups(static_cast<std::size_t>(layout_.bricks[0]), fill_group_pieces_) : 1),
      fill_kernel_(inputs.tools.kernel(inputs.tools.programs.fill, "fill_empty_bricks")),
      leave_kernel_(inputs.tools.kernel(inputs.tools.programs.fill, "leave_empty_bricks")),
      mark_kernel_(inputs.tools.kernel(inputs.tools.programs.fill, "mark_other_bricks")),
      finishing_(inputs.finishing),
      fill_outputs_(set_arguments(fill_kernel_, 0, layout_, *computed_, inputs.sign_bits)),
      leave_outputs_(set_arguments(leave_kernel_, 0, layout_, *computed_)),
      mark_outputs_(set_arguments(mark_kernel_, 0, layout_, *computed_, inputs.sign_bits)) {
    const DeviceTools& tools = inputs.tools;
    if (inputs.in_halves) divide_in_halves(most);
    if (!lists_.order.empty())
        order_ = device::copied(tools.context, tools.pool, lists_.order, "order of the coarse bricks");
    if (!inputs.wanted.empty())
        first_marks_ = device::copied(tools.context, tools.pool, marks_of(layout_, inputs.wanted), "marks of bricks");
    const double slice = static_cast<double>(layout_.size[0]) * static_cast<double>(layout_.size[1]);
    const std::size_t most_slices = inputs.launches.most(seconds_per_filled_sample * slice);
    if (most_slices < fill_group_slices_) fill_group_slices_ = 1;
    slices_per_fill_ = most_slices / fill_group_slices_ * fill_group_slices_;
    if (inputs.tools.context.is_first_use_of(fill_kernel_)) specialise_fill(inputs);
}

/// The bricks below the middle come first, the long lists first in each half.
void BrickScan::divide_in_halves(const LaunchWork& most) {
    const cl_int layers = layout_.coarse_bricks[2] / 2;
    const auto slices =
        static_cast<std::size_t>(std::max((layout_.coarse_first[2] + layers) * CLSDF_COARSE - layout_.first[2], 0));
    const std::size_t in_whole_fills = slices / fill_group_slices_ * fill_group_slices_;
    if (layers == 0 || in_whole_fills == 0) return;
    const auto upper = static_cast<cl_uint>(layers * layout_.coarse_bricks[1] * layout_.coarse_bricks[0]);
    std::vector<std::pair<cl_uint, cl_uint>> bricks;  // with their lengths
    for (std::size_t i = 0; i < lists_.order.size(); ++i) bricks.emplace_back(lists_.order[i], lists_.lengths[i]);
    const auto middle =
        std::stable_partition(bricks.begin(), bricks.end(), [&](const auto& brick) { return brick.first < upper; });
    for (std::size_t i = 0; i < bricks.size(); ++i) std::tie(lists_.order[i], lists_.lengths[i]) = bricks[i];
    const auto upper_begin = static_cast<cl_uint>(middle - bricks.begin());
    launches_ = launches_of(lists_, most, upper_begin);
    lower_.slices = static_cast<std::int32_t>(in_whole_fills);
    lower_.launches = static_cast<std::size_t>(
        std::ranges::count_if(launches_, [&](const BrickLaunch& launch) { return launch.begin < upper_begin; }));
}

/// Has the kernels that end a field compiled before the bricks', which another process may be compiling. Launches a
/// group of each behind the last slice, where it fills nothing.
void BrickScan::specialise_fill(const ScanInputs& inputs) {
    const cl_int behind = layout_.size[2];
    const cl::NDRange group(fill_group_pieces_, 1, fill_group_slices_);
    set_arguments(fill_kernel_, fill_outputs_, *computed_, cl_int{1}, cl_ulong{0}, cl_ulong{0}, behind);
    inputs.tools.queue().enqueueNDRangeKernel(fill_kernel_, cl::NullRange, group, group);
    fill_kernel_.note_launch();
    if (!inputs.variant.nearest) return;
    set_arguments(leave_kernel_, leave_outputs_, *computed_, cl_int{1}, behind);
    inputs.tools.queue().enqueueNDRangeKernel(leave_kernel_, cl::NullRange, group, group);
    leave_kernel_.note_launch();
}

void BrickScan::make_counters(const ScanInputs& inputs, std::size_t sets) {
    if (!inputs.variant.count) return;
    counter_sets_ = sets;
    counters_ = inputs.tools.pool->lease(sets * CLSDF_COUNTERS * sizeof(cl_ulong), "counters");
}

void BrickScan::set_outputs(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const {
    cl_uint next = set_arguments(kernel, first, outputs.listed, outputs[Output::distance]);
    if (finishing_ != nullptr) next = finishing_->set_arguments(kernel, next, outputs);
    if (counter_sets_ > 0) kernel.setArg(next, *counters_);
}

void BrickScan::enqueue_begin(CommandChain& chain, const OutputBuffers& outputs) {
    if (first_marks_.bytes() == 0)
        chain.then_fill(*computed_, bricks_);
    else
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueCopyBuffer(*first_marks_, *computed_, 0, 0, bricks_, wait, event);
        });
    chain.then_fill(*counters_, counter_sets_ * CLSDF_COUNTERS * sizeof(cl_ulong));
    enqueue_reset(chain, outputs);
    outputs_ = outputs;
}

void BrickScan::enqueue_end(CommandChain& chain) {
    if (outputs_.listed() != nullptr) {
        enqueue_other_bricks(chain);
        outputs_ = {};
        return;
    }
    enqueue_fill(chain, {static_cast<std::size_t>(lower_.slices), static_cast<std::size_t>(layout_.size[2])});
    outputs_ = {};
}

void BrickScan::enqueue_lower_end(CommandChain& chain) {
    enqueue_fill(chain, {0, static_cast<std::size_t>(lower_.slices)});
}

/// Fills the bricks of these slices that are not computed. The first slice is the first one of a group.
void BrickScan::enqueue_fill(CommandChain& chain, const Slices& slices) {
    const bool in_double = (outputs_.in_double & OutputSet(Output::distance).bits()) != 0;
    const cl_int words = in_double ? 2 : 1;
    const auto [inside, outside] =
        in_double ? std::pair(pattern_of(finishing_->inside_fill()), pattern_of(finishing_->outside_fill()))
                  : std::pair(pattern_of(layout_.inside_fill), pattern_of(layout_.outside_fill));
    enqueue_slices(chain, fill_kernel_,
                   set_arguments(fill_kernel_, fill_outputs_, outputs_[Output::distance], words, inside, outside),
                   in_groups(slices_per_fill_ / static_cast<std::size_t>(words)), slices);
    for (const OutputInfo& row : extra_outputs()) {
        const cl::Buffer& buffer = outputs_[row.output];
        if (buffer() == nullptr) continue;
        const std::size_t bytes = sample_bytes(row, (outputs_.in_double & bit_of(row)) != 0);
        enqueue_slices(chain, leave_kernel_,
                       set_arguments(leave_kernel_, leave_outputs_, buffer, static_cast<cl_int>(bytes)),
                       in_groups(slices_per_fill_ * sizeof(float) / std::max(bytes, sizeof(float))), slices);
    }
}

void BrickScan::describe(CallStatistics& statistics) const {
    statistics.coarse_pairs = lists_.pairs;
    statistics.coarse_bricks = lists_.order.size();
    if (first_marks_.bytes() > 0) statistics.device_bytes += computed_.bytes();
    statistics.device_bytes += counters_.bytes() + lists_.bounds.bytes() + lists_.starts.bytes() +
                               lists_.entries.bytes() + lists_.order.size() * sizeof(cl_uint) + computed_.bytes();
}

void BrickScan::read_counters(const device::Context& context, CallStatistics& statistics) const {
    if (counter_sets_ == 0) return;
    std::vector<cl_ulong> sets(counter_sets_ * CLSDF_COUNTERS);
    device::read_values(context, *counters_, sets);
    std::array<std::size_t, CLSDF_COUNTERS> sums{};
    for (std::size_t i = 0; i < sets.size(); ++i) sums[i % CLSDF_COUNTERS] += sets[i];
    statistics.brick_pairs = sums[CLSDF_COUNT_BRICK_PAIRS];
    statistics.lanes_evaluated = sums[CLSDF_COUNT_LANES];
    statistics.samples_covered = sums[CLSDF_COUNT_COVERED];
    statistics.band_samples = sums[CLSDF_COUNT_BAND];
}

/// The end of a sparse field.
void BrickScan::enqueue_other_bricks(CommandChain& chain) {
    chain.then([&](auto& queue, auto* wait, auto* event) {
        queue.enqueueCopyBuffer(outputs_.listed, outputs_.listed, CLSDF_STORED_COUNT * sizeof(cl_uint),
                                CLSDF_STORED_IN_BAND * sizeof(cl_uint), sizeof(cl_uint), wait, event);
    });
    const cl_uint last = set_arguments(mark_kernel_, mark_outputs_, outputs_.listed, outputs_[Output::distance]);
    const cl::NDRange group(fill_group_pieces_, 1, 1);
    divided({fill_pieces_, static_cast<std::size_t>(layout_.bricks[1]), static_cast<std::size_t>(layout_.bricks[2])},
            {most_groups, std::clamp<std::size_t>(slices_per_fill_ / CLSDF_BRICK, 1, most_groups)},
            [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                mark_kernel_.setArg(last, static_cast<cl_int>(z));
                chain.then_launch(mark_kernel_, cl::NDRange(0, y, 0), items, group);
            });
}

/// Enqueues slices of the empty bricks, in whole groups, at most `most` slices a launch. The kernel's argument
/// `last_argument` is a launch's first slice.
void BrickScan::enqueue_slices(CommandChain& chain, device::LentKernel& kernel, cl_uint last_argument, std::size_t most,
                               const Slices& slices) const {
    const auto brick_rows = static_cast<std::size_t>(layout_.bricks[1]);
    // The kernel skips slices beyond the last one.
    const std::size_t count = in_whole_groups(slices.end - slices.begin, fill_group_slices_);
    const cl::NDRange group(fill_group_pieces_, 1, fill_group_slices_);
    divided({fill_pieces_, brick_rows, count}, {most_groups, std::min(most, most_groups * fill_group_slices_)},
            [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                // An argument: PoCL compiles a kernel once more for offsets that are not 0.
                kernel.setArg(last_argument, static_cast<cl_int>(slices.begin + z));
                chain.then_launch(kernel, cl::NDRange(0, y, 0), items, group);
            });
}

/// Whole groups of no more slices, but one at least.
std::size_t BrickScan::in_groups(std::size_t slices) const {
    return std::max<std::size_t>(slices / fill_group_slices_, 1) * fill_group_slices_;
}

std::unique_ptr<FieldScan> make_brick_scan(const ScanInputs& inputs) {
    return is_by_group(inputs) ? make_bricks_by_group(inputs) : make_bricks_by_vector(inputs);
}

}  // namespace clsdf::engine

namespace clsdf {

void tuning::compile_bricks(const Device& device, OutputSet outputs) {
    device::Context& context = device::context_of(device);
    outputs.erase(Output::distance);
    const engine::BrickVariant variant{.nearest = !outputs.empty()};
    device::guarded([&] {
        const engine::Programs programs(context, KernelBody::automatic);
        if (programs.body == KernelBody::by_vector)
            engine::specialise_bricks_by_vector(context, programs, variant);
        else
            programs.bricks(context, variant);
    });
}

}  // namespace clsdf

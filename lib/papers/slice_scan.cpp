#include "papers/scans.hpp"

#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "launch/prefix_sums.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "kernel_sources.hpp"

namespace clsdf::papers {

namespace {

using engine::CommandChain;
using engine::OutputBuffers;
using engine::Programs;

// Keys and lists of a chunk take no more than this each, but for a single slice.
constexpr std::size_t chunk_bytes = std::size_t{32} << 20;
// A launch ends within a fifth of a second, if a core takes at most 50 nanoseconds a distance, and a small GPU 10.
constexpr double cost_per_core_and_launch = 4e6;
constexpr double cost_per_launch = 2e7;
constexpr std::size_t active_counted_at_once = std::size_t{1} << 23;

bool has_64_bit_atomics(const cl::Device& device) {
    const std::string extensions = device.getInfo<CL_DEVICE_EXTENSIONS>();
    return extensions.find("cl_khr_int64_extended_atomics") != std::string::npos;
}

class SliceScan final : public engine::FieldScan {
public:
    SliceScan(const engine::ScanInputs& inputs, const PreparedPieces& mesh, SliceMinimum minimum)
        : layout_(inputs.layout),
          variant_{inputs.variant, takes_64_bits(inputs.tools.context, layout_, inputs.variant.nearest, minimum)},
          shape_(slice_shape(inputs.tools.programs.body)),
          part_group_(inputs.tools.programs.part_group()),
          parts_(inputs.tools.programs.parallel_parts(inputs.tools.context, static_cast<std::size_t>(layout_.size[2]))),
          piece_count_(mesh.slices.size()) {
        device::Context& context = inputs.tools.context;
        schedule_ =
            schedule_slices(mesh.slices, layout_.first[2], layout_.size[2], limits(context, inputs.tools.programs));
        make_kernels(context, inputs.tools.programs, mesh);
        make_lists(inputs.tools);
        make_buffers(inputs.tools.pool, inputs.sign_bits);
        if (context.is_first_use_of(scan_kernel_)) warm_up(context);
    }

    std::size_t launch_count() const override { return schedule_.launches.size(); }
    double fraction_before(std::size_t launch) const override { return schedule_.launches[launch].fraction_before; }

    void enqueue_begin(CommandChain& chain, const OutputBuffers& outputs) override {
        cl_uint argument = finish_outputs_;
        finish_kernel_.setArg(argument++, outputs[Output::distance]);
        if (variant_.brick.nearest) finish_kernel_.setArg(argument++, outputs[Output::triangle]);
        if (variant_.brick.count) finish_kernel_.setArg(argument++, *band_samples_);
        chain.then_fill(*counters_, counters_.bytes());
        chain.then_fill(*band_samples_, band_samples_.bytes());
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueCopyBuffer(*starts_, *cursors_, 0, 0, cursor_count() * sizeof(cl_uint), wait, event);
        });
    }

    void enqueue_launch(CommandChain& chain, std::size_t number) override {
        const SliceLaunch& launch = schedule_.launches[number];
        const SliceChunk& chunk = schedule_.chunks[launch.chunk];
        if (number == 0 || schedule_.launches[number - 1].chunk != launch.chunk) begin_chunk(chain, chunk);
        if (launch.begin < launch.end) enqueue_scan(chain, chunk, launch);
        if (number + 1 == launch_count() || schedule_.launches[number + 1].chunk != launch.chunk)
            finish_chunk(chain, chunk);
    }

    void enqueue_end(CommandChain&) override {}

    void describe(CallStatistics& statistics) const override {
        count_named(statistics.method_counts, "active_pieces").value =
            schedule_.chunks.empty() ? 0 : schedule_.chunks.back().active_end;
        for (const device::BufferPool::Lease* lease : {&starts_, &cursors_, &active_, &keys_, &triangles_, &counters_})
            statistics.device_bytes += lease->bytes();
    }

    void read_counters(const device::Context& context, CallStatistics& statistics) const override {
        if (!variant_.brick.count) return;
        std::vector<cl_ulong> sets(counters_.bytes() / sizeof(cl_ulong));
        device::read_values(context, *counters_, sets);
        std::array<std::size_t, CLSDF_SLICES_COUNTERS> sums{};
        for (std::size_t i = 0; i < sets.size(); ++i) sums[i % CLSDF_SLICES_COUNTERS] += sets[i];
        count_named(statistics.method_counts, "slice_intersections").value = sums[CLSDF_SLICES_INTERSECTIONS];
        count_named(statistics.method_counts, "empty_intersections").value = sums[CLSDF_SLICES_EMPTY];
        statistics.lanes_evaluated = sums[CLSDF_SLICES_EVALUATED];
        statistics.samples_covered = sums[CLSDF_SLICES_COVERED];
        statistics.band_samples = sum_of(context, band_samples_, static_cast<std::size_t>(layout_.size[2]));
    }

private:
    enum ActiveArgument : cl_uint {
        active_layout,
        active_count,
        active_pieces,
        active_begin,
        active_end,
        active_counts,
        active_list,
        active_base,
        active_fill
    };
    enum ScanArgument : cl_uint {
        scan_layout,
        scan_begin,
        scan_end,
        scan_list,
        scan_pieces,
        scan_planes,
        scan_polyhedra,
        scan_first_slice,
        scan_keys,                 // alone, or the squared distances, the triangles
        scan_pass = scan_keys + 2  // and the pass; then the counters, where asked for
    };
    enum FinishArgument : cl_uint {
        finish_layout,
        finish_first_slice,
        finish_end_slice,
        finish_keys  // as the scan's; then the sign bits and finish_outputs_
    };

    /// Beside the distances, not in one key with them.
    bool has_triangles() const { return variant_.brick.nearest && !variant_.key_64; }

    std::size_t cursor_count() const { return static_cast<std::size_t>(layout_.size[2]) * parts_; }

    SliceLimits limits(const device::Context& context, const Programs& programs) const {
        const std::size_t bytes = std::min(chunk_bytes, context.capabilities().largest_allocation);
        const std::size_t key_bytes = variant_.key_64 ? sizeof(cl_ulong) : sizeof(cl_uint);
        const bool by_core = programs.body == KernelBody::by_vector;
        return {std::max<std::size_t>(1, bytes / (samples_of_slice(layout_) * key_bytes)), bytes / sizeof(cl_uint2),
                by_core ? cost_per_core_and_launch * context.capabilities().compute_units : cost_per_launch,
                has_triangles() ? 2 : 1};
    }

    void make_kernels(device::Context& context, const Programs& programs, const PreparedPieces& mesh) {
        const cl::Program program = slices_program(context, programs, variant_);
        active_kernel_ = {context.kernels(), program, "slices_active"};
        active_kernel_.setArg(active_layout, layout_);
        active_kernel_.setArg(active_count, static_cast<cl_uint>(piece_count_));
        active_kernel_.setArg(active_pieces, *mesh.pieces);
        scan_kernel_ = {context.kernels(), program, "slices_scan"};
        scan_kernel_.setArg(scan_layout, layout_);
        scan_kernel_.setArg(scan_pieces, *mesh.pieces);
        scan_kernel_.setArg(scan_planes, *mesh.planes);
        scan_kernel_.setArg(scan_polyhedra, *mesh.polyhedra);
        finish_kernel_ = {context.kernels(), program, "slices_finish"};
        finish_kernel_.setArg(finish_layout, layout_);
    }

    /// Where each slice's part of the active list begins.
    void make_lists(const engine::DeviceTools& tools) {
        const std::shared_ptr<device::BufferPool>& pool = tools.pool;
        cursors_ = pool->lease(cursor_count() * sizeof(cl_uint), "counts of the active pieces");
        starts_ = pool->lease((cursor_count() + 1) * sizeof(cl_uint), "starts of the active pieces");
        active_ = pool->lease(schedule_.most_active * sizeof(cl_uint2), "active pieces");
        const cl::CommandQueue& queue = tools.queue();
        queue.enqueueFillBuffer(*cursors_, cl_uint{0}, 0, cursor_count() * sizeof(cl_uint));
        active_kernel_.setArg(active_counts, *cursors_);
        active_kernel_.setArg(active_list, *active_);
        for (auto first = schedule_.chunks.begin(); first != schedule_.chunks.end();) {
            const auto next = std::find_if(first + 1, schedule_.chunks.end(), [&](const SliceChunk& chunk) {
                return chunk.active_end - first->active_begin > active_counted_at_once;
            });
            set_active_range(first->begin, (next - 1)->end, 0, false);
            engine::launch(queue, active_kernel_, {parts_, part_group_});
            first = next;
        }
        engine::PrefixSums sums(tools, *cursors_, *starts_, cursor_count(), "intersections of a piece and a slice");
        sums.total();  // throws if the starts do not hold it
    }

    void make_buffers(const std::shared_ptr<device::BufferPool>& pool, const cl::Buffer& sign_bits) {
        const std::size_t samples = schedule_.most_slices * samples_of_slice(layout_);
        keys_ = pool->lease(samples * (variant_.key_64 ? sizeof(cl_ulong) : sizeof(cl_uint)), "least distances");
        if (has_triangles()) triangles_ = pool->lease(samples * sizeof(cl_uint), "nearest triangles");
        if (variant_.brick.count) {
            std::size_t longest = 0;
            for (const SliceLaunch& launch : schedule_.launches) longest = std::max(longest, launch.end - launch.begin);
            counters_ = pool->lease(
                std::max<std::size_t>(work_items(longest), shape_.group) * CLSDF_SLICES_COUNTERS * sizeof(cl_ulong),
                "counters");
            band_samples_ = pool->lease(static_cast<std::size_t>(layout_.size[2]) * sizeof(cl_uint), "counters");
        }
        const auto set_keys = [&](cl::Kernel& kernel, cl_uint argument) {
            kernel.setArg(argument++, *keys_);
            if (!variant_.key_64) {
                kernel.setArg(argument++, has_triangles() ? *triangles_ : *keys_);
                kernel.setArg(argument++, cl_int{0});
            }
            return argument;
        };
        scan_kernel_.setArg(scan_list, *active_);
        const cl_uint counters = set_keys(scan_kernel_, scan_keys);
        if (variant_.brick.count) scan_kernel_.setArg(counters, *counters_);
        finish_outputs_ = set_keys(finish_kernel_, finish_keys);
        finish_kernel_.setArg(finish_outputs_++, sign_bits);
    }

    void warm_up(const device::Context& context) {
        const cl::CommandQueue& queue = context.queue();
        scan_kernel_.setArg(scan_begin, cl_uint{0});
        scan_kernel_.setArg(scan_end, cl_uint{0});
        scan_kernel_.setArg(scan_first_slice, layout_.first[2]);
        if (variant_.brick.count) queue.enqueueFillBuffer(*counters_, cl_uchar{0}, 0, counters_.bytes());
        engine::launch(queue, scan_kernel_, {shape_.group, shape_.group});
        finish_kernel_.setArg(finish_first_slice, layout_.first[2]);
        finish_kernel_.setArg(finish_end_slice, layout_.first[2]);
        cl_uint argument = finish_outputs_;
        finish_kernel_.setArg(argument++, *keys_);
        if (variant_.brick.nearest) finish_kernel_.setArg(argument++, *keys_);
        if (variant_.brick.count) finish_kernel_.setArg(argument++, *band_samples_);
        CommandChain chain(queue, {});
        enqueue_finish(chain, finish_kernel_, layout_, 1);
        context.finish();
    }

    void set_active_range(cl_int begin, cl_int end, std::size_t base, bool fill) {
        active_kernel_.setArg(active_begin, begin);
        active_kernel_.setArg(active_end, end);
        active_kernel_.setArg(active_base, static_cast<cl_uint>(base));
        active_kernel_.setArg(active_fill, cl_int{fill ? 1 : 0});
    }

    void begin_chunk(CommandChain& chain, const SliceChunk& chunk) {
        const std::size_t samples = static_cast<std::size_t>(chunk.end - chunk.begin) * samples_of_slice(layout_);
        const auto fill = [&](const device::BufferPool::Lease& keys, std::size_t bytes) {
            chain.then([&](auto& queue, auto* wait, auto* event) {
                queue.enqueueFillBuffer(*keys, no_key, 0, bytes, wait, event);
            });
        };
        fill(keys_, samples * (variant_.key_64 ? sizeof(cl_ulong) : sizeof(cl_uint)));
        if (has_triangles()) fill(triangles_, samples * sizeof(cl_uint));
        if (chunk.active_begin == chunk.active_end) return;
        set_active_range(chunk.begin, chunk.end, chunk.active_begin, true);
        chain.then_launch(active_kernel_, {parts_, part_group_});
    }

    void enqueue_scan(CommandChain& chain, const SliceChunk& chunk, const SliceLaunch& launch) {
        scan_kernel_.setArg(scan_begin, static_cast<cl_uint>(launch.begin));
        scan_kernel_.setArg(scan_end, static_cast<cl_uint>(launch.end));
        scan_kernel_.setArg(scan_first_slice, chunk.begin);
        if (!variant_.key_64) scan_kernel_.setArg(scan_pass, cl_int{launch.pass});
        chain.then_launch(scan_kernel_, {work_items(launch.end - launch.begin), shape_.group});
    }

    void finish_chunk(CommandChain& chain, const SliceChunk& chunk) {
        finish_kernel_.setArg(finish_first_slice, chunk.begin);
        finish_kernel_.setArg(finish_end_slice, chunk.end);
        enqueue_finish(chain, finish_kernel_, layout_, static_cast<std::size_t>(chunk.end - chunk.begin));
    }

    std::size_t work_items(std::size_t entries) const { return chunk_count(entries, shape_.batch) * shape_.group; }

    Layout layout_;
    SliceVariant variant_;
    SliceShape shape_;
    std::size_t part_group_;
    std::size_t parts_;  ///< work-items that share the making of the active list
    std::size_t piece_count_;
    SliceSchedule schedule_;
    device::BufferPool::Lease starts_;
    device::BufferPool::Lease cursors_;
    device::BufferPool::Lease active_;
    device::BufferPool::Lease keys_;       ///< or the squared distances, where keys have 32 bits
    device::BufferPool::Lease triangles_;  ///< if they are not in the keys
    device::BufferPool::Lease counters_;
    device::BufferPool::Lease band_samples_;
    device::LentKernel active_kernel_;
    device::LentKernel scan_kernel_;
    device::LentKernel finish_kernel_;
    cl_uint finish_outputs_ = 0;  ///< its first argument that changes from call to call
};

}  // namespace

std::size_t sum_of(const device::Context& context, const device::BufferPool::Lease& counters, std::size_t count) {
    std::vector<cl_uint> values(count);
    device::read_values(context, *counters, values);
    return std::accumulate(values.begin(), values.end(), std::size_t{0});
}

SliceShape slice_shape(KernelBody body) {
    return body == KernelBody::by_vector ? SliceShape{1, 8} : SliceShape{64, 64};
}

device::ProgramSource slices_source(const engine::ProgramSources& programs, const SliceVariant& variant) {
    // Rows of a piece are short: a vector is one brick's at most.
    const std::size_t lanes = std::min<std::size_t>(programs.lanes, CLSDF_BRICK);
    const SliceShape shape = slice_shape(programs.body);
    return {"slices.cl",
            fmt::format("{} -DGROUP={} -DBATCH={}{}{}", programs.common_options(lanes), shape.group, shape.batch,
                        options_of(variant.brick), variant.key_64 ? " -DKEY_64" : ""),
            kernels::files};
}

cl::Program slices_program(device::Context& context, const engine::ProgramSources& programs,
                           const SliceVariant& variant, const device::BuildWatch& watch) {
    return context.program(slices_source(programs, variant), watch);
}

void enqueue_finish(CommandChain& chain, const device::LentKernel& kernel, const Layout& layout, std::size_t slices) {
    constexpr std::size_t group = engine::common_group;
    const std::size_t row = engine::in_whole_groups(static_cast<std::size_t>(layout.size[0]), group);
    engine::divided({row, static_cast<std::size_t>(layout.size[1]), slices}, {engine::most_groups, engine::most_groups},
                    [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                        chain.then_launch(kernel, cl::NDRange(0, y, z), items, cl::NDRange(group, 1, 1));
                    });
}

bool takes_64_bits(const device::Context& context, const Layout& layout, bool with_triangle, SliceMinimum asked) {
    const bool has_atomics = has_64_bit_atomics(context.device());
    if (asked == SliceMinimum::one_pass && !has_atomics)
        throw Error(ErrorCode::unsupported,
                    "the device has no 64-bit atomics (cl_khr_int64_extended_atomics), which SliceMinimum::one_pass "
                    "needs; use two_passes");
    if (!with_triangle || asked == SliceMinimum::two_passes) return false;
    return asked == SliceMinimum::one_pass ||
           (has_atomics && samples_of_slice(layout) * sizeof(cl_ulong) <= context.capabilities().largest_allocation);
}

std::unique_ptr<engine::FieldScan> make_slice_scan(const engine::ScanInputs& inputs, SliceMinimum minimum) {
    return std::make_unique<SliceScan>(inputs, static_cast<const PreparedPieces&>(inputs.mesh), minimum);
}

}  // namespace clsdf::papers

#include "scan/sign_sweep.hpp"
#include "scan/commands.hpp"

#include "scan/layout_of.hpp"
#include "scan/programs.hpp"

namespace clsdf::scan {

namespace {

// Upper estimates for one core; they limit the work of a launch.
constexpr double seconds_per_record = 2e-8;
constexpr double seconds_per_word = 5e-9;  // of sign bits

// Rows that lie together, most of which meet no surface, of one work-item on a processor.
constexpr std::size_t rows_of_a_core = 64;

/// The keys of the crossings, row by row.
device::BufferPool::Lease keys_by_row(const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
                                      const Crossings& crossings, const ShortLaunches& launches) {
    auto keys = pool->lease(crossings.count * sizeof(cl_uint), "crossings of the sign's sweep by rows");
    cl::Kernel scatter(programs.sign_sweep, "sign_scatter");
    launches.over_items(scatter, crossings.record_count, seconds_per_record, [&](cl_uint begin, cl_uint end) {
        set_arguments(scatter, 0, begin, end, *crossings.records, *crossings.starts, *keys);
    });
    return keys;
}

}  // namespace

SignSweep::SignSweep(device::Context& context, const Programs& programs,
                     const std::shared_ptr<device::BufferPool>& pool, const Layout& layout, const SweepMesh* mesh,
                     const SweepSelection& selection, SignRule rule, const ShortLaunches& launches)
    : context_(context), programs_(programs), pool_(pool), layout_(layout), rule_(rule), launches_(launches) {
    device::guarded([&] {
        const std::size_t bytes =
            sign_row_count(layout) * static_cast<std::size_t>(layout.sign_words) * sizeof(cl_uint);
        result_.bits = pool->lease(bytes, "sign bits");
        const bool is_empty =
            mesh == nullptr || mesh->triangle_count == 0 || (selection.triangles() != nullptr && selection.count == 0);
        if (is_empty)
            context.queue().enqueueFillBuffer(*result_.bits, cl_uint{0}, 0, bytes);
        else
            search_ = std::make_unique<CrossingSearch>(context, programs, pool, layout, *mesh, selection, launches);
    });
}

SignBits SignSweep::finish() {
    return device::guarded([&] {
        if (search_) {
            const Crossings crossings = search_->finish();
            result_.has_large_triangles = crossings.has_large_triangles;
            sweep_rows(crossings);
        }
        return std::move(result_);
    });
}

void SignSweep::sweep_rows(const Crossings& crossings) {
    const auto keys = keys_by_row(programs_, pool_, crossings, launches_);
    const std::size_t rows = sign_row_count(layout_);
    cl::Kernel sweep(programs_.sign_sweep, "sign_rows");
    const std::size_t item_rows = programs_.body == KernelBody::by_group ? 1 : rows_of_a_core;
    const double words_and_keys =
        layout_.sign_words + 8.0 * static_cast<double>(crossings.record_count) / static_cast<double>(rows);
    launches_.over(rows, seconds_per_word * words_and_keys, [&](std::size_t begin, std::size_t end) {
        set_arguments(sweep, 0, layout_, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                      static_cast<cl_uint>(item_rows), cl_int{rule_ == SignRule::parity ? 1 : 0}, *crossings.starts,
                      *keys, *result_.bits);
        const std::size_t items = chunk_count(end - begin, item_rows);
        const std::size_t items_of_group = programs_.part_group();
        context_.queue().enqueueNDRangeKernel(sweep, cl::NullRange, cl::NDRange(in_whole_groups(items, items_of_group)),
                                              cl::NDRange(items_of_group));
    });
}

}  // namespace clsdf::scan

#include "transform/sign_sweep.hpp"

#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/sign_crossings.hpp"

namespace clsdf::transform {

namespace {

// Measured on a core, and rounded up.
constexpr double seconds_per_record = 2e-8;
constexpr double seconds_per_word = 5e-9;  // of sign bits

// Rows that lie together, most of which meet no surface, of one work-item on a processor.
constexpr std::size_t rows_of_a_core = 64;

enum ScatterArgument : cl_uint { scatter_begin, scatter_end, scatter_records, scatter_starts, scatter_keys };
enum RowsArgument : cl_uint {
    rows_layout,
    rows_begin,
    rows_end,
    rows_per_item,
    rows_parity,
    rows_starts,
    rows_keys,
    rows_sign_bits
};

/// The keys of the crossings, row by row.
device::BufferPool::Lease keys_by_row(device::Context& context, const Programs& programs,
                                      const std::shared_ptr<device::BufferPool>& pool, const Crossings& crossings,
                                      const ShortLaunches& launches) {
    auto keys = pool->lease(crossings.count * sizeof(cl_uint), "crossings of the sign's sweep by rows");
    cl::Kernel scatter(programs.sign_sweep, "sign_scatter");
    scatter.setArg(scatter_records, *crossings.records);
    scatter.setArg(scatter_starts, *crossings.starts);
    scatter.setArg(scatter_keys, *keys);
    launches.over(crossings.record_count, seconds_per_record, [&](std::size_t begin, std::size_t end) {
        scatter.setArg(scatter_begin, static_cast<cl_uint>(begin));
        scatter.setArg(scatter_end, static_cast<cl_uint>(end));
        context.queue().enqueueNDRangeKernel(scatter, cl::NullRange, cl::NDRange(in_whole_groups(end - begin)),
                                             cl::NDRange(common_group));
    });
    return keys;
}

}  // namespace

SignBits sweep_signs(device::Context& context, const Programs& programs,
                     const std::shared_ptr<device::BufferPool>& pool, const Layout& layout, const SweepMesh* mesh,
                     SignRule rule, const ShortLaunches& launches) {
    return device::guarded([&] {
        const cl::CommandQueue& queue = context.queue();
        const std::size_t rows = sign_row_count(layout);
        const std::size_t bytes = rows * static_cast<std::size_t>(layout.sign_words) * sizeof(cl_uint);
        SignBits result{pool->lease(bytes, "sign bits")};
        if (mesh == nullptr || mesh->triangle_count == 0) {
            queue.enqueueFillBuffer(*result.bits, cl_uint{0}, 0, bytes);
            return result;
        }
        const Crossings crossings = find_crossings(context, programs, pool, layout, *mesh, launches);
        result.has_large_triangles = crossings.has_large_triangles;
        const auto keys = keys_by_row(context, programs, pool, crossings, launches);

        cl::Kernel sweep(programs.sign_sweep, "sign_rows");
        const std::size_t item_rows = programs.body == KernelBody::by_group ? 1 : rows_of_a_core;
        sweep.setArg(rows_layout, layout);
        sweep.setArg(rows_per_item, static_cast<cl_uint>(item_rows));
        sweep.setArg(rows_parity, cl_int{rule == SignRule::parity ? 1 : 0});
        sweep.setArg(rows_starts, *crossings.starts);
        sweep.setArg(rows_keys, *keys);
        sweep.setArg(rows_sign_bits, *result.bits);
        const double words_and_keys =
            layout.sign_words + 8.0 * static_cast<double>(crossings.record_count) / static_cast<double>(rows);
        launches.over(rows, seconds_per_word * words_and_keys, [&](std::size_t begin, std::size_t end) {
            sweep.setArg(rows_begin, static_cast<cl_uint>(begin));
            sweep.setArg(rows_end, static_cast<cl_uint>(end));
            const std::size_t items = (end - begin + item_rows - 1) / item_rows;
            const std::size_t items_of_group = programs.part_group();
            queue.enqueueNDRangeKernel(sweep, cl::NullRange, cl::NDRange(in_whole_groups(items, items_of_group)),
                                       cl::NDRange(items_of_group));
        });
        return result;
    });
}

}  // namespace clsdf::transform

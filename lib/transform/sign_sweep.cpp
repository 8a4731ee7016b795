#include "transform/sign_sweep.hpp"

#include "sweep.h"
#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/scan.hpp"
#include "transform/sign_crossings.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace clsdf::transform {

namespace {

// A vertex moves by at most 2^-21 of the smallest spacing on each axis.
constexpr int snap_bits = 20;
// Of the snapped coordinates, so that differences fit 63 bits with room for the grid's own.
constexpr double snapped_limit = 0x1p61;

// Measured on a core, and rounded up.
constexpr double seconds_per_record = 2e-8;
constexpr double seconds_per_word = 5e-9;  // of sign bits

constexpr std::size_t group = 64;

std::size_t whole_groups(std::size_t items) {
    return (items + group - 1) / group * group;
}

/// Bits below a sample on an axis whose spacing is `ratio` voxels.
int bits_of(double ratio) {
    return snap_bits + static_cast<int>(std::ceil(std::log2(std::max(ratio, 1.0))));
}

device::BufferPool::Lease sweep_vertices(const cl::CommandQueue& queue, const std::shared_ptr<device::BufferPool>& pool,
                                         const Grid& grid, const Mesh& mesh, int bits_y, int bits_z) {
    const std::vector<Vec3>& positions = mesh.vertices();
    const std::size_t bytes = positions.size() * sizeof(SweepVertex);
    auto lease = pool->lease(bytes, "vertices of the sign's sweep");
    auto* vertices =
        static_cast<SweepVertex*>(queue.enqueueMapBuffer(*lease, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, bytes));
    const double scale_y = std::ldexp(1.0, bits_y), scale_z = std::ldexp(1.0, bits_z);
    std::atomic<std::size_t> too_far{positions.size()};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, positions.size(), 4096), [&](const auto& range) {
        for (std::size_t v = range.begin(); v != range.end(); ++v) {
            const auto sample = [&](std::size_t axis) {
                return (positions[v][axis] - grid.origin[axis]) / grid.spacing[axis];
            };
            const double y = std::nearbyint(sample(1) * scale_y);
            const double z = std::nearbyint(sample(2) * scale_z);
            // A vertex that is not finite is in no triangle, or the mesh would not be.
            if (!(std::abs(y) < snapped_limit) || !(std::abs(z) < snapped_limit)) {
                if (std::isfinite(y) && std::isfinite(z)) too_far = v;
                continue;
            }
            vertices[v] = {static_cast<std::int64_t>(y), static_cast<std::int64_t>(z), sample(0)};
        }
    });
    queue.enqueueUnmapMemObject(*lease, vertices);
    if (too_far < positions.size())
        throw Error(
            ErrorCode::unsupported,
            fmt::format(
                "vertex {} of {} lies more than 2^{} voxels from the grid's origin, too far for an exact sign; use a "
                "larger spacing or an unsigned field",
                too_far.load(), mesh.name(), 61 - std::max(bits_y, bits_z)));
    return lease;
}

/// The keys of the crossings, row by row; `starts` says where each row's begin.
device::BufferPool::Lease keys_by_row(device::Context& context, const Programs& programs,
                                      const std::shared_ptr<device::BufferPool>& pool, const Crossings& crossings,
                                      std::size_t rows, const cl::Buffer& starts, const ShortLaunches& launches) {
    constexpr const char* what = "crossings of the surface by rows of samples";
    const std::size_t count = scan(context, programs.scan, pool, *crossings.row_counts, starts, rows, what);
    // The counter of records has 32 bits and wraps; the scan's total shows it.
    if (count > crossings.record_count)
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("lists of {} are more than 2^32; compute a smaller part of the grid at a time", what));
    auto keys = pool->lease(count * sizeof(cl_uint), "crossings of the sign's sweep by rows");
    cl::Kernel scatter(programs.sign_sweep, "sign_scatter");
    scatter.setArg(2, *crossings.records);
    scatter.setArg(3, starts);
    scatter.setArg(4, *keys);
    launches.over(crossings.record_count, seconds_per_record, [&](std::size_t begin, std::size_t end) {
        scatter.setArg(0, static_cast<cl_uint>(begin));
        scatter.setArg(1, static_cast<cl_uint>(end));
        context.queue().enqueueNDRangeKernel(scatter, cl::NullRange, cl::NDRange(whole_groups(end - begin)),
                                             cl::NDRange(group));
    });
    return keys;
}

}  // namespace

device::BufferPool::Lease sweep_signs(device::Context& context, const Programs& programs,
                                      const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                                      const Grid& grid, const Mesh& mesh, SignRule rule, const cl::Buffer& triangles,
                                      const ShortLaunches& launches) {
    return device::guarded([&] {
        const cl::CommandQueue& queue = context.queue();
        const std::size_t rows = sign_row_count(layout);
        const std::size_t bytes = rows * static_cast<std::size_t>(layout.sign_words) * sizeof(cl_uint);
        auto bits = pool->lease(bytes, "sign bits");
        if (rule == SignRule::none) {
            queue.enqueueFillBuffer(*bits, cl_uint{0}, 0, bytes);
            return bits;
        }
        const int bits_y = bits_of(grid.spacing[1] / grid.voxel()), bits_z = bits_of(grid.spacing[2] / grid.voxel());
        const auto vertices = sweep_vertices(queue, pool, grid, mesh, bits_y, bits_z);
        const SweepMesh sweep_mesh{triangles, mesh.triangles().size(), *vertices, bits_y, bits_z};
        const Crossings crossings = find_crossings(context, programs, pool, layout, sweep_mesh, launches);
        const auto starts = pool->lease((rows + 1) * sizeof(cl_uint), "starts of the sign's crossings");
        const auto keys = keys_by_row(context, programs, pool, crossings, rows, *starts, launches);

        cl::Kernel sweep(programs.sign_sweep, "sign_rows");
        // On a processor a work-item takes rows that lie together, most of which it clears.
        const std::size_t rows_per_item = programs.body == KernelBody::by_group ? 1 : group;
        sweep.setArg(0, layout);
        sweep.setArg(3, static_cast<cl_uint>(rows_per_item));
        sweep.setArg(4, cl_int{rule == SignRule::parity ? 1 : 0});
        sweep.setArg(5, *starts);
        sweep.setArg(6, *keys);
        sweep.setArg(7, *bits);
        const double words_and_keys =
            layout.sign_words + 8.0 * static_cast<double>(crossings.record_count) / static_cast<double>(rows);
        launches.over(rows, seconds_per_word * words_and_keys, [&](std::size_t begin, std::size_t end) {
            sweep.setArg(1, static_cast<cl_uint>(begin));
            sweep.setArg(2, static_cast<cl_uint>(end));
            const std::size_t items = (end - begin + rows_per_item - 1) / rows_per_item;
            const std::size_t items_of_group = programs.part_group();
            queue.enqueueNDRangeKernel(sweep, cl::NullRange,
                                       cl::NDRange((items + items_of_group - 1) / items_of_group * items_of_group),
                                       cl::NDRange(items_of_group));
        });
        queue.finish();  // the transient buffers go back to the pool
        return bits;
    });
}

}  // namespace clsdf::transform

#include "transform/sign_sweep.hpp"

#include "sweep_vertex.h"
#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/scan.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace clsdf::transform {

namespace {

// A vertex moves by at most 2^-21 of the smallest spacing on each axis.
constexpr int snap_bits = 20;
// Of the snapped coordinates, so that differences fit 63 bits with room for the grid's own.
constexpr double snapped_limit = 0x1p61;

// Measured on a core, and rounded up: a row that is tested against a triangle, and a word of sign bits.
constexpr double seconds_per_row = 2e-8;
constexpr double seconds_per_word = 5e-9;
constexpr double rows_of_a_triangle = 3;  // what a triangle without rows takes
// A triangle of many rows is divided among work-items, each of which takes a strip of the slices.
constexpr std::size_t rows_per_item = std::size_t{1} << 14;
constexpr std::size_t most_strips = 64;

/// Rows in the boxes of the triangles.
struct SweepRows {
    std::size_t largest;
    double mean;
};

/// Bits below a sample on an axis whose spacing is `ratio` voxels.
int bits_of(double ratio) {
    return snap_bits + static_cast<int>(std::ceil(std::log2(std::max(ratio, 1.0))));
}

std::vector<SweepVertex> sweep_vertices(const Grid& grid, const Mesh& mesh, int bits_y, int bits_z) {
    const std::vector<Vec3>& positions = mesh.vertices();
    std::vector<SweepVertex> vertices(positions.size());
    std::atomic<std::size_t> too_far{positions.size()};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, positions.size(), 4096), [&](const auto& range) {
        for (std::size_t v = range.begin(); v != range.end(); ++v) {
            const auto sample = [&](std::size_t axis) {
                return (positions[v][axis] - grid.origin[axis]) / grid.spacing[axis];
            };
            const double y = std::nearbyint(std::ldexp(sample(1), bits_y));
            const double z = std::nearbyint(std::ldexp(sample(2), bits_z));
            // A vertex that is not finite is in no triangle, or the mesh would not be.
            if (!(std::abs(y) < snapped_limit) || !(std::abs(z) < snapped_limit)) {
                if (std::isfinite(y) && std::isfinite(z)) too_far = v;
                continue;
            }
            vertices[v] = {static_cast<std::int64_t>(y), static_cast<std::int64_t>(z), sample(0)};
        }
    });
    if (too_far < positions.size())
        throw Error(
            ErrorCode::unsupported,
            fmt::format(
                "vertex {} of {} lies more than 2^{} voxels from the grid's origin, too far for an exact sign; use a "
                "larger spacing or an unsigned field",
                too_far.load(), mesh.name(), 61 - std::max(bits_y, bits_z)));
    return vertices;
}

SweepRows rows_of(const std::vector<SweepVertex>& vertices, const Mesh& mesh, const Layout& layout, int bits_y,
                  int bits_z) {
    const auto rows_between = [&layout](std::int64_t low, std::int64_t high, int bits, std::size_t axis) {
        const std::int64_t first = std::int64_t{layout.brick_first[axis]} * CLSDF_BRICK;
        const std::int64_t end = first + std::int64_t{layout.bricks[axis]} * CLSDF_BRICK;
        return static_cast<std::size_t>(
            std::max<std::int64_t>(std::min(high >> bits, end - 1) - std::max(low >> bits, first) + 1, 0));
    };
    struct Sums {
        std::size_t largest = 0;
        double total = 0;
    };
    const std::vector<Triangle>& triangles = mesh.triangles();
    const Sums sums = tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, triangles.size(), 4096), Sums{},
        [&](const auto& range, Sums part) {
            for (std::size_t t = range.begin(); t != range.end(); ++t) {
                const auto& [a, b, c] = triangles[t];
                const auto [low_y, high_y] = std::minmax({vertices[a].y, vertices[b].y, vertices[c].y});
                const auto [low_z, high_z] = std::minmax({vertices[a].z, vertices[b].z, vertices[c].z});
                const std::size_t rows =
                    rows_between(low_y, high_y, bits_y, 1) * rows_between(low_z, high_z, bits_z, 2);
                part.largest = std::max(part.largest, rows);
                part.total += static_cast<double>(rows);
            }
            return part;
        },
        [](Sums one, const Sums& other) {
            return Sums{std::max(one.largest, other.largest), one.total + other.total};
        });
    return {sums.largest, sums.total / static_cast<double>(triangles.size())};
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
        const double voxel = grid.voxel();
        const int bits_y = bits_of(grid.spacing[1] / voxel), bits_z = bits_of(grid.spacing[2] / voxel);
        const std::vector<SweepVertex> host_vertices = sweep_vertices(grid, mesh, bits_y, bits_z);
        const auto vertices = pool->lease(host_vertices.size() * sizeof(SweepVertex), "vertices of the sign's sweep");
        queue.enqueueWriteBuffer(*vertices, CL_TRUE, 0, host_vertices.size() * sizeof(SweepVertex),
                                 host_vertices.data());

        const auto cursors = pool->lease(rows * sizeof(cl_uint), "counts of the sign's crossings");
        const auto starts = pool->lease((rows + 1) * sizeof(cl_uint), "starts of the sign's crossings");
        queue.enqueueFillBuffer(*cursors, cl_uint{0}, 0, rows * sizeof(cl_uint));
        constexpr std::size_t group = 64;
        const auto whole_groups = [](std::size_t items) { return (items + group - 1) / group * group; };
        cl::Kernel crossings(programs.sign_sweep, "sign_crossings");
        crossings.setArg(0, layout);
        crossings.setArg(3, triangles);
        crossings.setArg(4, *vertices);
        crossings.setArg(5, cl_int{bits_y});
        crossings.setArg(6, cl_int{bits_z});
        crossings.setArg(7, *cursors);
        crossings.setArg(8, *cursors);  // no keys yet
        crossings.setArg(9, cl_int{0});
        const SweepRows sweep_rows = rows_of(host_vertices, mesh, layout, bits_y, bits_z);
        const std::size_t strips = std::min(sweep_rows.largest / rows_per_item + 1, most_strips);
        const double seconds_per_triangle =
            seconds_per_row * (sweep_rows.mean + rows_of_a_triangle * static_cast<double>(strips));
        const auto launch_crossings = [&] {
            launches.over(mesh.triangles().size(), seconds_per_triangle, [&](std::size_t begin, std::size_t end) {
                crossings.setArg(1, static_cast<cl_uint>(begin));
                crossings.setArg(2, static_cast<cl_uint>(end));
                queue.enqueueNDRangeKernel(crossings, cl::NullRange, cl::NDRange(whole_groups(end - begin), strips),
                                           cl::NDRange(group, 1));
            });
        };
        launch_crossings();
        const std::size_t crossing_count =
            scan(context, programs.scan, pool, *cursors, *starts, rows, "crossings of the surface by rows of samples");

        const auto keys = pool->lease(crossing_count * sizeof(cl_uint), "crossings of the sign's sweep");
        queue.enqueueCopyBuffer(*starts, *cursors, 0, 0, rows * sizeof(cl_uint));
        crossings.setArg(8, *keys);
        crossings.setArg(9, cl_int{1});
        launch_crossings();

        cl::Kernel sweep(programs.sign_sweep, "sign_rows");
        sweep.setArg(0, layout);
        sweep.setArg(3, cl_int{rule == SignRule::parity ? 1 : 0});
        sweep.setArg(4, *starts);
        sweep.setArg(5, *keys);
        sweep.setArg(6, *bits);
        const double words_and_keys =
            layout.sign_words + 8.0 * static_cast<double>(crossing_count) / static_cast<double>(rows);
        launches.over(rows, seconds_per_word * words_and_keys, [&](std::size_t begin, std::size_t end) {
            sweep.setArg(1, static_cast<cl_uint>(begin));
            sweep.setArg(2, static_cast<cl_uint>(end));
            queue.enqueueNDRangeKernel(sweep, cl::NullRange, cl::NDRange(whole_groups(end - begin)),
                                       cl::NDRange(group));
        });
        queue.finish();  // the transient buffers go back to the pool
        return bits;
    });
}

}  // namespace clsdf::transform

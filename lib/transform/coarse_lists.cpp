#include "transform/coarse_lists.hpp"

#include "coarse.h"
#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/scan.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace clsdf::transform {

namespace {

// Surface points that the coarse bounds look at, at most: they need not be tight.
constexpr std::size_t cap_points = 4096;

// What polyhedra touch is kept from counting to filling by groups of coarse bricks, so many for each polyhedron on
// average. Where there are more, they are found twice.
constexpr std::size_t kept_touches = 4;

// Coarse bricks whose bounds lie together: 4 x 4 x 4.
constexpr std::size_t coarse_group_size = 64;

std::size_t coarse_group_count(const Layout& layout) {
    std::size_t count = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t first = layout.coarse_first[axis];
        const std::int32_t last = first + layout.coarse_bricks[axis] - 1;
        count *= static_cast<std::size_t>((last >> 2) - (first >> 2) + 1);
    }
    return count;
}

// Measured on a core, and rounded up.
constexpr double seconds_per_point = 1e-8;  // for a vector of bricks
constexpr double seconds_per_group = 5e-7;

/// In a narrow band hardly any bound of a coarse brick is below the half width.
bool has_uniform_caps(const Layout& layout) {
    return layout.half_width <= 2 * layout.coarse_radius;
}

void bound_coarse_bricks(device::Context& context, const Programs& programs,
                         const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                         const cl::Buffer& polyhedra, std::size_t polyhedron_count, const cl::Buffer& caps,
                         const ShortLaunches& launches) {
    const cl::CommandQueue& queue = context.queue();
    const std::size_t bricks = coarse_group_count(layout) * coarse_group_size;
    if (has_uniform_caps(layout) || polyhedron_count == 0) {
        queue.enqueueFillBuffer(caps, layout.half_width, 0, bricks * sizeof(float));
        return;
    }
    const std::size_t stride = std::max<std::size_t>(1, polyhedron_count / cap_points);
    const std::size_t count = (polyhedron_count + stride - 1) / stride;
    const auto points = pool->lease(count * sizeof(SurfacePoint), "points of the surface");
    cl::Kernel gather(programs.coarse_lists, "coarse_points");
    gather.setArg(0, static_cast<cl_uint>(stride));
    gather.setArg(1, static_cast<cl_uint>(count));
    gather.setArg(2, polyhedra);
    gather.setArg(3, *points);
    queue.enqueueNDRangeKernel(gather, cl::NullRange, cl::NDRange(count));

    cl::Kernel kernel(programs.coarse_lists, "coarse_caps");
    kernel.setArg(0, layout);
    kernel.setArg(1, static_cast<cl_uint>(count));
    kernel.setArg(2, *points);
    kernel.setArg(3, caps);
    const double seconds = seconds_per_point * static_cast<double>(count);
    launches.over(bricks / programs.lanes, seconds, [&](std::size_t begin, std::size_t end) {
        kernel.setArg(4, static_cast<cl_uint>(begin));
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(end - begin));
    });
    queue.finish();  // the points go back to the pool
}

/// About what the lists of a polyhedron take a core: the groups of coarse bricks that its box overlaps, triangles being
/// small as a rule.
double seconds_per_polyhedron(const Layout& layout) {
    double groups = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double most = layout.coarse_bricks[axis] / 4.0 + 1;
        groups *= std::min(most, 2.0 * static_cast<double>(layout.half_width) / (4.0 * CLSDF_COARSE) + 1.5);
    }
    return seconds_per_group * (groups + 1);
}

/// They only save a second search: without room for them there are none.
device::BufferPool::Lease lease_touches(device::BufferPool& pool, std::size_t parts, std::size_t& capacity) {
    try {
        return pool.lease(parts * capacity * sizeof(Touch), "touches of the coarse lists");
    } catch (const Error& error) {
        if (error.code() != ErrorCode::out_of_memory) throw;
        capacity = 0;
        return pool.lease(0, "touches of the coarse lists");
    }
}

}  // namespace

CoarseLists make_coarse_lists(device::Context& context, const Programs& programs,
                              const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                              const cl::Buffer& polyhedra, std::size_t polyhedron_count,
                              const ShortLaunches& launches) {
    return device::guarded([&] {
        const cl::CommandQueue& queue = context.queue();
        const std::size_t bricks = coarse_brick_count(layout);
        CoarseLists lists;
        lists.parts = programs.parallel_parts(context, bricks);
        const std::size_t counters = bricks * lists.parts;
        lists.caps =
            pool->lease(coarse_group_count(layout) * coarse_group_size * sizeof(float), "bounds of the coarse bricks");
        bound_coarse_bricks(context, programs, pool, layout, polyhedra, polyhedron_count, *lists.caps, launches);

        const auto histograms = pool->lease(counters * sizeof(cl_uint), "histograms of the coarse lists");
        const auto counts = pool->lease(counters * sizeof(cl_uint), "counts of the coarse lists");
        lists.starts = pool->lease((counters + 1) * sizeof(cl_uint), "starts of the coarse lists");
        std::size_t capacity = std::min((kept_touches * polyhedron_count + lists.parts - 1) / lists.parts,
                                        context.capabilities().largest_allocation / (lists.parts * sizeof(Touch)));
        const device::BufferPool::Lease touches = lease_touches(*pool, lists.parts, capacity);
        const auto touch_counts = pool->lease(lists.parts * sizeof(cl_uint), "touches of the coarse lists");
        cl::Kernel kernel(programs.coarse_lists, "coarse_lists");
        kernel.setArg(0, layout);
        kernel.setArg(1, static_cast<cl_uint>(polyhedron_count));
        kernel.setArg(2, polyhedra);
        kernel.setArg(3, *lists.caps);
        kernel.setArg(4, cl_int{has_uniform_caps(layout) ? 1 : 0});
        kernel.setArg(5, *histograms);
        kernel.setArg(6, *counts);
        kernel.setArg(7, *lists.starts);
        kernel.setArg(8, *counts);  // no entries yet
        kernel.setArg(9, static_cast<cl_uint>(capacity));
        kernel.setArg(10, *touches);
        kernel.setArg(11, *touch_counts);
        kernel.setArg(12, cl_int{0});
        const auto launch = [&] {
            const std::size_t steps = polyhedron_count / launches.most(seconds_per_polyhedron(layout)) + 1;
            kernel.setArg(14, static_cast<cl_uint>(steps));
            launches.one_by_one(steps, [&](std::size_t step) {
                kernel.setArg(13, static_cast<cl_uint>(step));
                queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(lists.parts),
                                           cl::NDRange(programs.part_group()));
            });
        };
        launch();

        lists.pairs = scan(context, programs.scan, pool, *counts, *lists.starts, counters,
                           "pairs of a triangle and a coarse brick");
        constexpr std::size_t vector = 16;  // kernels read whole ones at a list's end
        lists.entries = pool->lease((lists.pairs + vector) * sizeof(cl_uint), "coarse lists");

        kernel.setArg(8, *lists.entries);
        kernel.setArg(12, cl_int{1});
        launch();

        std::vector<cl_uint> starts(counters + 1);
        queue.enqueueReadBuffer(*lists.starts, CL_TRUE, 0, starts.size() * sizeof(cl_uint), starts.data());
        const auto length = [&](cl_uint brick) {
            return starts[(std::size_t{brick} + 1) * lists.parts] - starts[std::size_t{brick} * lists.parts];
        };
        for (cl_uint brick = 0; brick < bricks; ++brick)
            if (length(brick) > 0) lists.order.push_back(brick);
        // The long lists first, so that cores end together; among those of like length neighbours follow each other,
        // because they share polyhedra (measured: a tenth of the bricks' time).
        std::stable_sort(lists.order.begin(), lists.order.end(),
                         [&](cl_uint a, cl_uint b) { return std::bit_width(length(a)) > std::bit_width(length(b)); });
        lists.lengths.reserve(lists.order.size());
        for (const cl_uint brick : lists.order) lists.lengths.push_back(length(brick));
        return lists;
    });
}

}  // namespace clsdf::transform

#include "transform/coarse_lists.hpp"

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

// Pairs of a polyhedron and a coarse brick that are kept from counting to filling, for each polyhedron on average.
// Where there are more, they are found twice.
constexpr std::size_t kept_pairs = 8;

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
constexpr double seconds_per_point = 2e-8;
constexpr double seconds_per_group = 5e-7;

/// In a narrow band no bound of a coarse brick is below the half width.
bool has_uniform_caps(const Layout& layout) {
    return layout.half_width <= 2 * layout.coarse_radius;
}

void bound_coarse_bricks(device::Context& context, const Programs& programs, const Layout& layout,
                         const cl::Buffer& polyhedra, std::size_t polyhedron_count, const cl::Buffer& caps,
                         std::size_t bricks, const ShortLaunches& launches) {
    const std::size_t bytes = coarse_group_count(layout) * coarse_group_size * sizeof(float);
    context.queue().enqueueFillBuffer(caps, has_uniform_caps(layout) ? layout.half_width : 0, 0, bytes);
    if (has_uniform_caps(layout)) return;
    cl::Kernel kernel(programs.coarse_lists, "coarse_caps");
    kernel.setArg(0, layout);
    kernel.setArg(1, static_cast<cl_uint>(polyhedron_count));
    const std::size_t stride = std::max<std::size_t>(1, polyhedron_count / cap_points);
    kernel.setArg(2, static_cast<cl_uint>(stride));
    kernel.setArg(3, polyhedra);
    kernel.setArg(4, caps);
    const double seconds = seconds_per_point * static_cast<double>(polyhedron_count / stride + 1);
    launches.over(bricks, seconds, [&](std::size_t begin, std::size_t end) {
        kernel.setArg(5, static_cast<cl_uint>(begin));
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(end - begin));
    });
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
        bound_coarse_bricks(context, programs, layout, polyhedra, polyhedron_count, *lists.caps, bricks, launches);

        const auto counts = pool->lease(counters * sizeof(cl_uint), "counts of the coarse lists");
        constexpr std::size_t pair_bytes = 2 * sizeof(cl_uint);
        const std::size_t capacity = std::min((kept_pairs * polyhedron_count + lists.parts - 1) / lists.parts,
                                              context.capabilities().largest_allocation / (lists.parts * pair_bytes));
        const auto pairs = pool->lease(lists.parts * capacity * pair_bytes, "pairs of the coarse lists");
        const auto pair_counts = pool->lease(lists.parts * sizeof(cl_uint), "pairs of the coarse lists");
        cl::Kernel kernel(programs.coarse_lists, "coarse_lists");
        kernel.setArg(0, layout);
        kernel.setArg(1, static_cast<cl_uint>(polyhedron_count));
        kernel.setArg(2, polyhedra);
        kernel.setArg(3, *lists.caps);
        kernel.setArg(4, *counts);
        kernel.setArg(5, *counts);  // no entries yet
        kernel.setArg(6, static_cast<cl_uint>(capacity));
        kernel.setArg(7, *pairs);
        kernel.setArg(8, *pair_counts);
        kernel.setArg(9, cl_int{0});
        const auto launch = [&] {
            const std::size_t steps = polyhedron_count / launches.most(seconds_per_polyhedron(layout)) + 1;
            kernel.setArg(11, static_cast<cl_uint>(steps));
            launches.one_by_one(steps, [&](std::size_t step) {
                kernel.setArg(10, static_cast<cl_uint>(step));
                queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(lists.parts),
                                           cl::NDRange(programs.part_group()));
            });
        };
        launch();

        lists.starts = pool->lease((counters + 1) * sizeof(cl_uint), "starts of the coarse lists");
        lists.pairs = scan(context, programs.scan, pool, *counts, *lists.starts, counters,
                           "pairs of a triangle and a coarse brick");
        constexpr std::size_t vector = 16;  // kernels read whole ones at a list's end
        lists.entries = pool->lease((lists.pairs + vector) * sizeof(cl_uint), "coarse lists");

        queue.enqueueCopyBuffer(*lists.starts, *counts, 0, 0, counters * sizeof(cl_uint));
        kernel.setArg(5, *lists.entries);
        kernel.setArg(9, cl_int{1});
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

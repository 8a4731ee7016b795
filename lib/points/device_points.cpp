#include "points/device_points.hpp"

#include "hilbert_curve.h"
#include "launch/commands.hpp"
#include "launch/programs.hpp"
#include "launch/radix_sort.hpp"
#include "mesh/triples.hpp"

#include <algorithm>

namespace clsdf::points {

namespace {

// Groups that measure points, and how many points make another one worthwhile.
constexpr std::size_t most_measuring_groups = 512, measured_together = 1024;

}  // namespace

DevicePoints DevicePoints::part(std::size_t begin, std::size_t part_count) const {
    DevicePoints result = *this;
    result.source.first += static_cast<clsdf_int64>(begin) * source.stride;
    result.count = part_count;
    return result;
}

DevicePoints points_in(const InputArray& array) {
    const Steps steps = steps_of(array);
    return {cl::Buffer(array.device, true),
            {static_cast<clsdf_int64>(array.offset), steps.triple, steps.number, array.type == ElementType::float64},
            array.count};
}

DevicePoints packed_points(const cl::Buffer& positions, std::size_t count) {
    return {positions, {0, sizeof(Vec3), sizeof(double), 1}, count};
}

PointLimits limits_of(const Box& box) {
    PointLimits limits{};
    std::copy(box.lower.begin(), box.lower.end(), limits.lower);
    std::copy(box.upper.begin(), box.upper.end(), limits.upper);
    return limits;
}

device::BufferPool::Lease measure_points(const engine::DeviceTools& tools, const DevicePoints& points,
                                         const PointLimits& usable, const Box& most) {
    return device::guarded([&] {
        const std::size_t groups = std::clamp<std::size_t>(points.count / measured_together, 1, most_measuring_groups);
        const device::BufferPool::Lease extents = tools.pool->lease(groups * sizeof(PointExtent), "extents of points");
        device::BufferPool::Lease cells = tools.pool->lease(sizeof(PointCells), "cells of points");
        const cl::Program program = tools.programs.point_order;
        cl::Kernel measure(program, "measure_points"), join(program, "join_extents");
        engine::launch(tools.queue(), measure, {groups * engine::common_group}, points.source,
                       static_cast<cl_uint>(points.count), usable, points.memory, *extents);
        engine::launch(tools.queue(), join, {engine::common_group}, static_cast<cl_uint>(groups), limits_of(most),
                       *extents, *cells);
        return cells;
    });
}

std::array<UnusablePoints, 2> unusable_points(const engine::DeviceTools& tools, const DevicePoints& points,
                                              const cl::Buffer& cells) {
    return device::guarded([&] {
        PointCells found{};
        tools.queue().enqueueReadBuffer(cells, CL_TRUE, 0, sizeof found, &found);
        std::array<UnusablePoints, 2> result;
        for (const int why : {CLSDF_POINT_NOT_FINITE, CLSDF_POINT_TOO_FAR}) {
            UnusablePoints& unusable = result[why == CLSDF_POINT_TOO_FAR];
            unusable = {why == CLSDF_POINT_TOO_FAR, found.unusable[why], found.first[why], {}};
            if (unusable.count == 0) continue;
            const auto first = points.source.first + static_cast<clsdf_int64>(unusable.first) * points.source.stride;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto at =
                    static_cast<std::size_t>(first + static_cast<clsdf_int64>(axis) * points.source.component);
                float single = 0;
                if (points.source.is_double != 0) {
                    tools.queue().enqueueReadBuffer(points.memory, CL_TRUE, at, sizeof(double),
                                                    &unusable.position[axis]);
                } else {
                    tools.queue().enqueueReadBuffer(points.memory, CL_TRUE, at, sizeof single, &single);
                    unusable.position[axis] = static_cast<double>(single);
                }
            }
        }
        return result;
    });
}

OrderedPoints order_points(const engine::DeviceTools& tools, const DevicePoints& points, const PointLimits& usable,
                           const cl::Buffer& cells, const engine::LatticeView& lattice, std::size_t first_place) {
    return device::guarded([&] {
        const auto lease = [&](std::size_t bytes, const char* purpose) {
            return tools.pool->lease(points.count * bytes, purpose);
        };
        const auto count = static_cast<cl_uint>(points.count);
        const cl::Program program = tools.programs.point_order;
        const device::BufferPool::Lease order = lease(sizeof(cl_uint), "order of points");
        {
            const device::BufferPool::Lease keys = lease(sizeof(cl_uint), "keys of points");
            cl::Kernel make_keys(program, "keys_of_points");
            engine::launch(tools.queue(), make_keys, {points.count}, points.source, count, usable, points.memory, cells,
                           *keys);
            engine::sort_by_keys(tools, *keys, points.count, 3 * CLSDF_CURVE_BITS, *order);
        }
        PointUnits units{{}, lattice.unit};
        std::copy(lattice.origin.begin(), lattice.origin.end(), units.origin);
        OrderedPoints result{lease(sizeof(Vec3), "points"), lease(sizeof(cl_uint), "places of points")};
        cl::Kernel gather(program, "gather_points");
        engine::launch(tools.queue(), gather, {points.count}, points.source, count, usable, units,
                       static_cast<cl_uint>(first_place), points.memory, *order, *result.in_units, *result.places);
        return result;
    });
}

}  // namespace clsdf::points

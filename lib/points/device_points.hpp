#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "frusta/frames.hpp"
#include "launch/device_tools.hpp"
#include "point_order.h"
#include "points/usable_points.hpp"

#include <array>
#include <cstddef>

/// The caller's points in memory of the device, for the body by_group.
namespace clsdf::points {

struct DevicePoints {
    cl::Buffer memory;
    PointSource source{};
    std::size_t count = 0;

    /// Points that follow each other.
    DevicePoints part(std::size_t begin, std::size_t part_count) const;
};

/// Those of an array in memory of the device that has been checked.
DevicePoints points_in(const InputArray& array);
/// Packed positions, in a buffer of the library's own.
DevicePoints packed_points(const cl::Buffer& positions, std::size_t count);

/// As kernels read it.
PointLimits limits_of(const Box& box);

/// Finds the box of the points, as far as it lies in `most`, and the points that are not within `usable`. Does not
/// wait. The lease has a PointCells.
device::BufferPool::Lease measure_points(const engine::DeviceTools& tools, const DevicePoints& points,
                                         const PointLimits& usable, const Box& most);

/// The points that measure_points() has found not to be usable: those that are not finite, and those too far. Waits.
std::array<UnusablePoints, 2> unusable_points(const engine::DeviceTools& tools, const DevicePoints& points,
                                              const cl::Buffer& cells);

/// Points as a search reads them.
struct OrderedPoints {
    device::BufferPool::Lease in_units;  ///< a Vec3 of each
    device::BufferPool::Lease places;    ///< a cl_uint of each: where its results go
};

/// The points in the order of curve_order(), if `cells` are theirs and all are usable. Points that are not usable
/// become the lattice's origin. first_place: of the first point's results. Does not wait.
OrderedPoints order_points(const engine::DeviceTools& tools, const DevicePoints& points, const PointLimits& usable,
                           const cl::Buffer& cells, const engine::LatticeView& lattice, std::size_t first_place);

}  // namespace clsdf::points

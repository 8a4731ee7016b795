#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "point_order.h"
#include "points/usable_points.hpp"
#include "targets/target_overlap.hpp"

#include <array>
#include <cstddef>

/// The caller's points in memory of the device.
namespace clsdf::points {

struct DevicePoints {
    cl::Buffer memory;
    PointSource source{};
    std::size_t count = 0;

    /// Points that follow each other.
    DevicePoints part(std::size_t begin, std::size_t part_count) const;
};

/// Throws Error(invalid_argument) if the memory of an array of points, whose layout has been checked, is no buffer of
/// the context, may not be read by kernels or is too small; Error(unsupported) for memory of the host.
void check_device_points(const device::Context& context, const InputArray& points);
/// The bytes of points of the device, for targets::find_overlap(). Throws cl::Error.
targets::WrittenArray array_of(const InputArray& points);
/// Those of an array in memory of the device that has been checked.
DevicePoints points_in(const InputArray& array);
/// Packed positions, in a buffer of the library's own.
DevicePoints packed_points(const cl::Buffer& positions, std::size_t count);

/// As kernels read it.
PointLimits limits_of(const Box& box);

/// The points that were found not to be usable: those that are not finite, and those too far. Waits if there are some.
std::array<UnusablePoints, 2> unusable_points(const engine::DeviceTools& tools, const DevicePoints& points,
                                              const PointCells& found);

}  // namespace clsdf::points

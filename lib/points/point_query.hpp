#pragma once

#include <clsdf/mesh.hpp>

#include "launch/device_tools.hpp"
#include "points/device_points.hpp"
#include "points/point_run.hpp"
#include "targets/host_arrays.hpp"

#include <functional>
#include <span>

namespace clsdf::points {

/// Times of parts of a query, in seconds of the host's clock.
struct PointTimes {
    double nearest = 0;
    double sign = 0;
};

/// The outputs of at most `most_points` points into packed arrays on the host. `between`, which may be empty and may
/// throw, is called between launches with the fraction done. Throws Error(device_failure or out_of_memory).
PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points,
                        double half_width, const targets::HostArrays& arrays,
                        const std::function<void(double)>& between);

/// Measures points, and waits for what is found.
PointCells measured_points(const engine::DeviceTools& tools, PointRun& run, const DevicePoints& all,
                           const PointLimits& usable, const engine::PointFaces& mesh);

/// Points in memory of the device, of which at most most_points are computed at once.
struct DeviceBatch {
    DevicePoints points;
    PointLimits usable;
    const DevicePoints* all;  ///< the points that are measured first; null: they have been
};

/// The same into packed arrays of the device, which hold the outputs when it returns. The host sees only those points
/// whose sign neither their nearest faces, nor the mesh's box, nor exact predicates of kernels tell. Waits once, unless
/// there are such points. copy, which may be empty, enqueues what follows the outputs. found: the points that are not
/// usable.
PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, PointRun& run,
                        const DeviceBatch& batch, double half_width, const engine::OutputBuffers& outputs,
                        const std::function<void(const engine::Launches&)>& copy, PointCells& found,
                        const std::function<void(double)>& between);

}  // namespace clsdf::points

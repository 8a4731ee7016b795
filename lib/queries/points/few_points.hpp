#pragma once

#include "points/point_query.hpp"

#include <cstddef>
#include <span>

/// Few points are looked up by the host, on the calling thread: the launches of a device take longer.
namespace clsdf::points {

/// The most points of such a call. With more, two cores are faster by the kernels.
inline constexpr std::size_t most_few_points = 96;

/// Gets what answer_points() reads into the host's memory, if it is not there. It stays there as long as the inputs
/// live. For one thread at a time. Throws Error(device_failure or out_of_memory).
void bring_to_host(const PointInputs& inputs);

/// The outputs of at most `most_few_points` points into packed arrays, with the bytes of query_points(). inputs: of
/// bring_to_host(). Enqueues nothing. For any number of threads at once.
PointTimes answer_points(const PointInputs& inputs, std::span<const Vec3> points, double half_width,
                         const scan::HostArrays& arrays);

}  // namespace clsdf::points

#pragma once

#include "points/point_query.hpp"

#include <cstddef>
#include <cstdint>
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
                         const targets::HostArrays& arrays);

/// The sources of finishing in the host's memory (kernels/finish/finish.h).
struct FinishingSources {
    engine::Finishing how;
    const Polyhedron* polyhedra = nullptr;
    const TriangleSites* sites = nullptr;
    const float* normals = nullptr;
};

/// Those of inputs of bring_to_host(), which must outlive them.
FinishingSources finishing_sources(const PointInputs& inputs);

/// The outputs of one sample or point whose nearest polyhedron is known, by the code of the kernels. sample: in samples
/// of the lattice of `how`. sign: CLSDF_POINT_INSIDE, _OUTSIDE or _ON_SURFACE. For callers that have made a
/// DefaultFloatingPoint.
void finish_on_host(const FinishingSources& sources, const Vec3& sample, std::uint32_t polyhedron, std::uint8_t sign,
                    double half_width, const targets::HostArrays& arrays);

/// The nearest face of a point, and its squared distance in units. If no face is within the limit, the face is
/// CLSDF_NO_FACE, and the squared distance is the limit.
struct NearestOfPoint {
    std::uint32_t face;
    double squared;
};
/// inputs: of bring_to_host(). most: of search_limit(), or less. near: a face that is likely to be near, or
/// CLSDF_NO_FACE; set to the face that is found. For callers that have made a DefaultFloatingPoint.
NearestOfPoint find_nearest(const PointInputs& inputs, const Vec3& in_units, double most, std::uint32_t& near);

}  // namespace clsdf::points

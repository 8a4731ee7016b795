#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "points/face_sides.hpp"
#include "points/point_mesh.hpp"
#include "points/point_scan.hpp"
#include "transform/finishing.hpp"
#include "transform/programs.hpp"
#include "transform/slab_pipeline.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

namespace clsdf::points {

/// What the outputs of points follow from.
struct PointInputs {
    std::shared_ptr<const PointMesh> mesh;
    std::shared_ptr<const ScannedMesh> scanned;           ///< null: points are looked up one by one
    std::shared_ptr<const FaceSides> sides;               ///< null: signs by crossings; else the sites have normals
    std::shared_ptr<const transform::DeviceSites> sites;  ///< with normals if the gradient is asked for
    SignRule sign = SignRule::none;
    bool is_inside_out = false;  ///< the faces look inwards, and the points have a sign
};

/// Times of parts of a query, in seconds of the host's clock.
struct PointTimes {
    double nearest = 0;
    double sign = 0;
};

/// Points that are computed at once. The memory that they take is bounded by it; results do not depend on it.
inline constexpr std::size_t most_points = std::size_t{1} << 20;

/// Throws Error(invalid_argument) that names the first point that is not finite or too far from the mesh.
void check_points(const PointMesh& mesh, std::span<const Vec3> points);

/// The outputs of at most `most_points` points into packed arrays on the host. `between`, which may be empty and may
/// throw, is called between launches with the fraction done. Throws Error(device_failure or out_of_memory).
PointTimes query_points(device::Context& context, const transform::Programs& programs,
                        const std::shared_ptr<device::BufferPool>& pool, const PointInputs& inputs,
                        std::span<const Vec3> points, double within, const transform::HostArrays& arrays,
                        const std::function<void(double)>& between);

/// Builds the programs and, the first time on this device and driver version, computes a small known field at its
/// samples and compares. Returns whether it was tested here. Throws Error(device_failure) that says what differs.
bool ensure_points_tested(const Device& device, const transform::Programs& programs, bool are_scanned,
                          const device::BuildWatch& watch = {});

/// How often `begins` of a watch is called by ensure_points_tested() for programs that have not been tested, about.
inline constexpr std::size_t point_test_steps = 3;

}  // namespace clsdf::points

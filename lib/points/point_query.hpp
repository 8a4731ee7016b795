#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "finish/finishing.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"
#include "points/device_points.hpp"
#include "points/face_sides.hpp"
#include "points/point_scan.hpp"
#include "targets/host_arrays.hpp"
#include "tree/binary_tree.hpp"
#include "tree/point_mesh.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

namespace clsdf::points {

/// The inputs of a query.
struct PointInputs {
    std::shared_ptr<const engine::PointMesh> mesh;
    std::shared_ptr<const engine::FittedTree> tree;    ///< of the body by_group alone
    std::shared_ptr<const ScannedMesh> scanned;        ///< null: points are looked up one by one
    std::shared_ptr<const FaceSides> sides;            ///< null: signs by crossings; else the sites have normals
    std::shared_ptr<const engine::DeviceSites> sites;  ///< with normals if the gradient is asked for
    SignRule sign = SignRule::none;
    bool is_inside_out = false;   ///< the faces look inwards, and the points have a sign
    bool has_deep_stack = false;  ///< the body by_group searches with the large stack, however deep the tree is

    bool needs_deep_stack() const { return has_deep_stack || (tree && tree->divided->depth > engine::stack_entries); }
};

/// Times of parts of a query, in seconds of the host's clock.
struct PointTimes {
    double nearest = 0;
    double sign = 0;
};

/// Points that are computed at once. The memory that they take is bounded by it; results do not depend on it.
inline constexpr std::size_t most_points = std::size_t{1} << 20;

/// The limit of the search for the nearest face: a squared distance in units, above all rounding of what is compared
/// with `half_width` at the end.
double search_limit(const engine::PointMesh& mesh, double half_width);

/// The outputs of at most `most_points` points into packed arrays on the host. `between`, which may be empty and may
/// throw, is called between launches with the fraction done. Throws Error(device_failure or out_of_memory).
PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points,
                        double half_width, const targets::HostArrays& arrays,
                        const std::function<void(double)>& between);

/// The box in which points are ordered along a curve: that of the mesh and its surroundings.
Box box_of_curve(const engine::PointMesh& mesh);

/// Points in memory of the device that are computed at once.
struct DeviceBatch {
    DevicePoints points;  ///< at most most_points
    PointLimits usable;
    const cl::Buffer& cells;      ///< of measure_points()
    bool has_unusable;            ///< some points may not be usable
    std::size_t first_place = 0;  ///< of the first point's results; that of the last one is below 2^32
};

/// The same into packed arrays of the device, which hold the outputs when it returns. The host sees no points but those
/// whose sign neither their nearest faces nor the mesh's box tell. For the body by_group.
PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, const DeviceBatch& batch,
                        double half_width, const engine::OutputBuffers& outputs,
                        const std::function<void(double)>& between);

}  // namespace clsdf::points

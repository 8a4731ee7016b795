#pragma once

#include "benchmarks/measure.hpp"

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::bench {

/// The cost and the errors of distances at points of one kind.
struct PointCost {
    std::string name;
    std::string what;
    std::string method = "clsdf";
    std::size_t points = 0;      ///< of a measurement, all its calls together
    std::size_t calls = 1;       ///< of a measurement
    Spread seconds{};            ///< by the clock on the wall
    Spread processor_seconds{};  ///< user and system time of all threads
    std::size_t judged = 0;      ///< points compared with the reference
    std::size_t wrong = 0;       ///< off by more than 1e-5 voxel and 2 ulp
    std::size_t wrong_signs = 0;
    std::optional<double> limit{};  ///< the least accepted points_per_second()
    double max_error_voxels = 0;    ///< a voxel is 1/256 of the mesh's longest side

    double points_per_second() const { return static_cast<double>(points) / seconds.median; }
};

/// Signed distances at points without a limit, by a transform that has been used before: uniform in the mesh's box and
/// 10% around it, near the surface, along rays, and in many small calls; and the first call of a transform. Beside the
/// first three, the same points by Embree's point query with pseudonormals, if it is built in. The first two also from
/// memory of the device to memory of the device, by a query and by a run of a plan.
std::vector<PointCost> measure_points(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                      bool is_quick);

/// The same of the caller's points, in one call.
std::vector<PointCost> measure_these_points(const Mesh& mesh, std::span<const Vec3> points, const Device& device,
                                            const MeasureOptions& options);

/// Random points in the mesh's box and 10% of its longest side around it.
std::vector<Vec3> points_around(const Mesh& mesh, std::size_t count, std::uint64_t seed);

}  // namespace clsdf::bench

#pragma once

#include "benchmarks/measure.hpp"

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::bench {

/// The cost and the errors of rays or links of one kind.
struct RayCost {
    std::string name;
    std::string what;
    std::string method = "clsdf";
    std::size_t rays = 0;           ///< or links that were found
    std::optional<double> limit{};  ///< of the seconds: the project's bar
    Spread seconds{};               ///< by the clock on the wall
    Spread processor_seconds{};     ///< user and system time of all threads
    std::size_t judged = 0;         ///< rays compared with rational arithmetic
    std::size_t wrong = 0;          ///< that miss what is met, or meet what is not, or are off by more than 1e-3 voxel
    double max_error_voxels = 0;    ///< of the others; a voxel is 1/256 of the mesh's longest side

    double rays_per_second() const { return static_cast<double>(rays) / seconds.median; }
};

/// First faces, by a transform that has been used before: rays between random points of the mesh's box and 10% around
/// it, parallel ones, and ones from afar to the middles of edges and to vertices; of the first also the first walls,
/// the number of all faces, and whether there is any. Beside first faces the same rays by Embree in its robust mode, if
/// it is built in.
std::vector<RayCost> measure_rays(const Mesh& mesh, const Device& device, const MeasureOptions& options, bool is_quick);

/// Compares at most 500 of these first faces with rational arithmetic, for `judged`, `wrong` and `max_error_voxels`.
void judge_first_faces(const Mesh& mesh, std::span<const Vec3> origins, std::span<const Vec3> directions,
                       std::span<const double> t, const MeasureOptions& options, RayCost& cost);

}  // namespace clsdf::bench

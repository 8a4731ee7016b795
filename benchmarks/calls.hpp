#pragma once

#include "benchmarks/measure.hpp"

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::bench {

/// The cost of calls of one kind divided by that of another kind, in one run.
struct CallCost {
    std::string name;
    std::string what;
    Spread seconds{};               ///< time of the calls
    Spread base_seconds{};          ///< time of the calls that they are divided by
    double ratio = 0;               ///< quotient of the medians
    std::optional<double> limit{};  ///< the largest accepted ratio
    std::size_t judged = 0;         ///< samples, points or boxes compared with the reference, all from timed calls
    /// Off by more than 1e-5 voxel and 2 ulp, or with a wrong sign; with another output that breaks its contract; boxes
    /// with a place that one of their points refutes.
    std::size_t wrong = 0;
    double max_error_voxels = 0;  ///< the largest error of a sample of the band
};

/// The calls of a time step: a grid again, outputs beside the distance, one sample, one point, patches of three levels,
/// vertices that move (then a field, points or the run of a plan), boxes to classify, many small meshes.
std::vector<CallCost> measure_calls(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                    bool is_quick);

}  // namespace clsdf::bench

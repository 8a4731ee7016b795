#pragma once

#include "benchmarks/method.hpp"
#include "benchmarks/truth.hpp"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::bench {

struct MeasureOptions {
    std::size_t repetitions = 7;
    /// A method that takes the list computes as many of its bricks as take about this long.
    double seconds_per_call = 1;
    /// A method that needs longer than this for all repetitions gets fewer, three at least; clsdf gets all.
    double seconds_per_method = 21;
    std::size_t samples_judged = 20000;  ///< 0: every sample of the grid
    std::uint64_t seed = 1;
    std::function<void(const std::string& method)> progress{};  ///< before each call
};

/// A method on a workload: its cost and its errors.
struct Measurement {
    std::string method;
    std::string note;
    std::size_t stride = 1;                 ///< every stride-th brick was computed, and the cost scaled to all of them
    std::vector<double> wall;               ///< seconds of each call, in the order of the calls
    std::vector<double> processor;          ///< user and system seconds of each
    std::optional<std::size_t> peak_bytes;  ///< growth of the resident memory in the first call, the field excluded
    Judgement judgement;                    ///< the worst of all timed calls
};

/// Minimum, median and maximum.
struct Spread {
    double least = 0, median = 0, most = 0;
};
Spread spread_of(std::vector<double> values);

/// Each method is warmed up and judged, then timed in turns, one call each. All write to the same array, which is
/// filled with NaN before every call to show samples that were not computed. The values of every call are judged,
/// outside the time.
std::vector<Measurement> measure_in_turns(const Workload& workload, const std::vector<Method*>& methods,
                                          const MeasureOptions& options);

}  // namespace clsdf::bench

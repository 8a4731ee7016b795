#pragma once

#include "benchmarks/call_judge.hpp"
#include "benchmarks/calls.hpp"
#include "benchmarks/cost.hpp"

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace clsdf::bench {

inline constexpr double band_voxels = 3;

inline double seconds_of(const std::function<void()>& calls) {
    const CostWatch watch;
    calls();
    return watch.cost().wall;
}

/// The mesh, the device and the options of the measurements of calls.
struct CallJob {
    const Mesh& mesh;
    const Device& device;
    const MeasureOptions& options;
    bool is_quick;

    std::int64_t scaled(std::int64_t resolution) const { return is_quick ? resolution / 8 : resolution; }

    Grid grid(std::int64_t resolution) const {
        const double side = mesh.box().longest_side();
        const auto samples = static_cast<double>(scaled(resolution));
        return Grid::around(mesh, scaled(resolution),
                            Band::symmetric(band_voxels * side / (samples - 1 - 2 * band_voxels)));
    }
    static Band band(const Grid& grid) { return Band::symmetric(band_voxels * grid.voxel()); }
    DistanceTransform transform() const { return {device, mesh}; }

    /// Both kinds of calls take turns; each pair gives one ratio's parts.
    template <typename Calls, typename Base>
    void measure(CallCost& cost, const Calls& calls, const Base& base) const {
        std::vector<double> seconds, base_seconds;
        for (std::size_t n = 0; n < options.repetitions + 1; ++n) {
            if (options.progress) options.progress(cost.name);
            const double of_base = base();
            const double of_calls = calls();
            if (n == 0) continue;  // warms up
            base_seconds.push_back(of_base);
            seconds.push_back(of_calls);
        }
        cost.seconds = spread_of(seconds);
        cost.base_seconds = spread_of(base_seconds);
        cost.ratio = cost.seconds.median / cost.base_seconds.median;
    }
};

// One sample, and boxes: patches of levels, all boxes of the band, boxes to classify.

CallCost measure_one_sample(const CallJob& job, CallJudge& judge);
CallCost measure_patches(const CallJob& job, CallJudge& judge, bool in_one_call);
CallCost measure_band_boxes(const CallJob& job, CallJudge& judge);
CallCost measure_classify(const CallJob& job, CallJudge& judge);

// Vertices that move, and memory of the device.

CallCost measure_moved(const CallJob& job, const char* name, std::int64_t resolution);
CallCost measure_moved_points(const CallJob& job);
CallCost measure_device_first(const CallJob& job, CallJudge& judge);
/// A moved step into memory of the device; the positions come from there, too, or from the host.
CallCost measure_step(const CallJob& job, bool from_device);

}  // namespace clsdf::bench

#pragma once

#include "benchmarks/floors.hpp"
#include "benchmarks/measure.hpp"

namespace clsdf::bench {

/// The times of clsdf's stages on a workload: medians over the calls, in seconds, and the counts of one call.
struct Stages {
    Spread whole;
    double polyhedra = 0;
    double lists = 0;  ///< of the coarse bricks, the sign left out
    double sign = 0;
    double bricks = 0;    ///< the kernels' own time, by the device
    double fill = 0;      ///< the same
    double transfer = 0;  ///< rest of the field's stage: queueing, and copies if the device has its own memory
    double rest = 0;      ///< buffers, and gaps between the stages
    TransformStatistics counts;
    Judgement judgement;

    /// Seconds in which the device could write the field, and evaluate one distance for each sample of the band.
    double store_floor = 0;
    double evaluation_floor = 0;
    /// The larger floor as a part of the whole.
    double part_of_floor() const {
        return (store_floor > evaluation_floor ? store_floor : evaluation_floor) / whole.median;
    }
};

Stages measure_stages(const Workload& workload, const Device& device, const Floors& floors,
                      const MeasureOptions& options);

}  // namespace clsdf::bench

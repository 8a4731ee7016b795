#pragma once

#include <clsdf/device.hpp>

namespace clsdf::bench {

/// Lower bounds of the device's time, measured by small kernels; each the best of several runs.
struct Floors {
    double store_bytes_per_second = 0;
    double store_past_caches_bytes_per_second = 0;  ///< 0 if the compiler has no such store
    double fma_per_second = 0;         ///< floating-point operations: a fused multiply and add counts as two
    double launch_seconds = 0;         ///< an empty launch, waited for
    double launch_in_row_seconds = 0;  ///< one of many, waited for at the end

    double best_store() const {
        return store_bytes_per_second > store_past_caches_bytes_per_second ? store_bytes_per_second
                                                                           : store_past_caches_bytes_per_second;
    }
};

Floors measure_floors(const Device& device);

/// Operations a lane of the distance from a sample to one triangle in its frame, of kernels/bricks/lane_offsets.h; a
/// fused multiply and add is two.
inline constexpr double operations_of_a_distance = 34;

/// The same device with a profiling queue: TransformStatistics then has the kernels' own times.
Device with_profiling(const Device& device);

}  // namespace clsdf::bench

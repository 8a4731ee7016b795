#pragma once

#include "benchmarks/measure.hpp"

#include <clsdf/clsdf.hpp>

namespace clsdf::test {

/// A job of a second: a sphere of 512 triangles in a band of 10%, or every sample.
inline bench::Workload small_workload(Length half_width = Length::of_extent(0.1)) {
    return bench::make_workload({"small", 33, half_width}, "sphere3", make_shape("sphere3"), Device::strongest());
}

inline bench::MeasureOptions every_sample() {
    bench::MeasureOptions options;
    options.repetitions = 2;
    options.samples_judged = 0;
    return options;
}

inline bench::Measurement measure(const bench::Workload& workload, bench::Method& method,
                                  const bench::MeasureOptions& options = every_sample()) {
    return measure_in_turns(workload, {&method}, options).front();
}

}  // namespace clsdf::test

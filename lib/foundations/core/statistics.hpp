#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/tuning.hpp>

#include <array>
#include <memory>

namespace clsdf {

/// The statistics of a call while it runs.
struct CallStatistics : TransformStatistics, WorkCounts {
    /// What the caller gets.
    TransformStatistics published() const {
        TransformStatistics statistics = *this;
        statistics.work = std::make_shared<const WorkCounts>(*this);
        return statistics;
    }
};

/// What the device counts.
inline constexpr std::array device_counts{&WorkCounts::brick_pairs, &WorkCounts::lanes_evaluated,
                                          &WorkCounts::samples_covered, &WorkCounts::band_samples};

/// The count of this name, which is added if there is none.
MethodCount& count_named(std::vector<MethodCount>& counts, const std::string& name);

/// Adds what a slab took to what the slabs before it took.
void add_slab(CallStatistics& total, const CallStatistics& slab);

/// Adds what a call took to what the calls before it took.
void add_call(CallStatistics& total, const CallStatistics& call);

}  // namespace clsdf

#include "benchmarks/measure.hpp"

#include "benchmarks/memory.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::bench {

namespace {

void forget(std::span<float> distance) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, distance.size(), std::size_t{1} << 20),
                      [&](const auto& range) {
                          std::fill(distance.begin() + static_cast<std::ptrdiff_t>(range.begin()),
                                    distance.begin() + static_cast<std::ptrdiff_t>(range.end()),
                                    std::numeric_limits<float>::quiet_NaN());
                      });
}

/// The largest stride whose bricks have at least half of their share of the samples. In a small job, bricks with few
/// samples would stand for all.
std::size_t largest_fair_stride(const SampleList& list) {
    std::size_t stride = largest_stride;
    while (stride > 1 && 2 * stride * list.count(stride) < list.samples.size()) stride /= 2;
    return stride;
}

/// One method's calls on a workload.
class Course {
public:
    Course(const Workload& workload, Method& method, const Truth& truth, std::span<float> distance)
        : workload_(workload), method_(method), truth_(truth), distance_(distance) {
        result_.method = method.name();
        result_.note = method.note();
    }

    const std::string& name() const { return result_.method; }
    bool has_turns_left() const { return result_.wall.size() < turns_; }

    /// The first calls: chooses the stride and the number of repetitions, and measures the memory.
    void warm_up(const MeasureOptions& options) {
        method_.prepare(workload_);
        if (method_.takes_list()) {
            const std::size_t largest = largest_fair_stride(workload_.list);
            const double whole = call(largest).wall;
            while (result_.stride < largest && whole / static_cast<double>(result_.stride) > options.seconds_per_call)
                result_.stride *= 2;
        }
        PeakMemory memory;
        const CostWatch watch;
        call(result_.stride);
        result_.peak_bytes = memory.growth();
        const auto affordable = static_cast<std::size_t>(options.seconds_per_method / watch.cost().wall);
        turns_ = method_.gets_every_call() ? options.repetitions
                                           : std::min(options.repetitions, std::max<std::size_t>(affordable, 3));
    }

    void take_turn() {
        const Cost cost = call(result_.stride);
        result_.wall.push_back(cost.wall);
        result_.processor.push_back(cost.processor);
    }

    const Measurement& result() const { return result_; }

private:
    /// The cost of the whole job, from the bricks of the stride.
    Cost call(std::size_t stride) {
        forget(distance_);
        const CostWatch watch;
        const Cost set_up = method_.compute(workload_, distance_, stride);
        const Cost all = watch.cost();
        result_.judgement.take_worse(truth_.judge(distance_, method_.takes_list(), stride));
        if (!method_.takes_list() || stride == 1) return all;
        const double share = static_cast<double>(workload_.list.samples.size()) /
                             static_cast<double>(std::max<std::size_t>(workload_.list.count(stride), 1));
        return {set_up.wall + (all.wall - set_up.wall) * share,
                set_up.processor + (all.processor - set_up.processor) * share};
    }

    const Workload& workload_;
    Method& method_;
    const Truth& truth_;
    std::span<float> distance_;
    std::size_t turns_ = 0;
    Measurement result_;
};

}  // namespace

Spread spread_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    const double median = values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
    return {values.front(), median, values.back()};
}

std::vector<Measurement> measure_in_turns(const Workload& workload, const std::vector<Method*>& methods,
                                          const MeasureOptions& options) {
    const Truth truth(workload, options.samples_judged, options.seed);
    FieldArray<float> distance(workload.grid.sample_count());  // like the library's own arrays
    forget(distance);  // filled here, so that no method's first call pays for its page faults
    const auto announce = [&](const Course& course) {
        if (options.progress) options.progress(course.name());
    };
    std::vector<Course> courses;
    for (Method* method : methods) {
        courses.emplace_back(workload, *method, truth, distance);
        announce(courses.back());
        courses.back().warm_up(options);
    }
    for (std::size_t turn = 0; turn < options.repetitions; ++turn)
        for (Course& course : courses)
            if (course.has_turns_left()) {
                announce(course);
                course.take_turn();
            }
    std::vector<Measurement> measurements;
    for (const Course& course : courses) measurements.push_back(course.result());
    return measurements;
}

}  // namespace clsdf::bench

#include "calls/call.hpp"

#include "core/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::calls {

template <typename Function, typename... Arguments>
auto RunningCall::pass_on(const Function& function, const Arguments&... arguments) {
    try {
        return function(arguments...);
    } catch (...) {
        has_thrown = true;
        throw;
    }
}

void RunningCall::throw_if_stopped() {
    if (options.should_stop && pass_on(options.should_stop))
        throw Error(ErrorCode::cancelled, "the computation was cancelled");
}

void RunningCall::report(const Progress& progress) {
    if (options.progress) pass_on(options.progress, progress);
}

std::function<void(double)> RunningCall::between(double begin, double end) {
    if (!options.progress && !options.should_stop) return {};
    return [this, begin, end](double fraction) {
        throw_if_stopped();
        report({.fraction = begin + (end - begin) * fraction});
    };
}

CallOptions part_of(const CallOptions& call, double begin, double end) {
    CallOptions part = call;
    if (call.progress)
        part.progress = [&call, begin, end](Progress progress) {
            if (progress.stage == Progress::Stage::computing)
                progress.fraction = std::lerp(begin, end, progress.fraction);
            call.progress(progress);
        };
    return part;
}

void RunningCall::compile(std::size_t expected, const std::function<bool(const device::BuildWatch&)>& ensure) {
    const Stopwatch watch;
    const auto report_as = [this, expected](Progress::Stage stage) {
        return [this, expected, stage] {
            ++step;
            throw_if_stopped();
            const std::size_t steps = std::max(expected, step);
            report({stage, static_cast<double>(step - 1) / static_cast<double>(steps), step, steps});
        };
    };
    statistics.first_use |= ensure({report_as(Progress::Stage::compiling), report_as(Progress::Stage::testing)});
    statistics.compile_seconds += watch.seconds();
}

const CallStatistics& RunningCall::finish() {
    report({.fraction = 1});
    return statistics;
}

}  // namespace clsdf::calls

#pragma once

#include "core/lifetime.hpp"
#include "launch/commands.hpp"

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

namespace clsdf::plans {

/// Runs of a plan that may be unfinished. A run that fails ends at once, even before the runs that it waits for. So the
/// end of the latest does not mean that all have ended.
class Runs {
public:
    /// A new run, whose commands are to be enqueued: they wait for `before`, and for the latest run that has not ended.
    /// All that are enqueued count, even if a later one cannot be.
    engine::CommandChain& begin(const cl::CommandQueue& queue, std::vector<cl::Event> before) {
        std::erase_if(running_, is_over);
        const auto latest = std::find_if(running_.rbegin(), running_.rend(),
                                         [](const auto& run) { return !device::has_ended(run.last()); });
        if (latest != running_.rend()) before.push_back(latest->last());
        return running_.emplace_back(queue, std::move(before));
    }

    /// Waits for all of them, whether they fail or not. Returns the error of a wait that could not be made.
    cl_int wait() noexcept {
        for (; !running_.empty(); running_.pop_front()) {
            engine::CommandChain& run = running_.front();
            if (run.has_begun() && !device::has_ended(run.last())) {
                const cl_int code = clWaitForEvents(1, &run.last()());
                if (code != CL_SUCCESS && code != CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) return code;
            }
            if (!is_over(run)) keep_for_good(run);
        }
        return CL_SUCCESS;
    }

private:
    /// PoCL 3.1 ends the process in this case: a command fails, its event is released, and later an event of its wait
    /// list ends. So a run stays until the events of its commands and of their wait list have ended.
    static bool is_over(const engine::CommandChain& run) {
        return !run.has_begun() || (std::ranges::all_of(run.events(), device::has_ended) &&
                                    std::ranges::all_of(run.awaited(), device::has_ended));
    }

    std::deque<engine::CommandChain> running_;  // in their order
};

}  // namespace clsdf::plans

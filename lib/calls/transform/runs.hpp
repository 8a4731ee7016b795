#pragma once

#include "core/lifetime.hpp"
#include "launch/commands.hpp"

#include <algorithm>
#include <deque>
#include <iterator>
#include <utility>
#include <vector>

namespace clsdf::transform {

/// Runs of a plan that may be unfinished. A run that fails ends at once, even before the runs that it waits for. So the
/// end of the latest does not mean that all have ended.
class Runs {
public:
    void add(const scan::CommandChain& commands) {
        std::erase_if(running_, [](const Run& run) { return run.is_over(); });
        running_.push_back({commands.last(), commands.awaited()});
        running_.back().events.insert(running_.back().events.end(), commands.events().begin(), commands.events().end());
    }

    /// The event that the next run must wait for: the end of the latest that has not ended. Null if all have ended.
    cl::Event latest() const {
        const auto last = std::find_if(running_.rbegin(), running_.rend(),
                                       [](const Run& run) { return !device::has_ended(run.end); });
        return last == running_.rend() ? cl::Event() : last->end;
    }

    /// Waits for all of them, whether they fail or not. Returns the error of a wait that could not be made.
    cl_int wait() noexcept {
        for (; !running_.empty(); running_.pop_front()) {
            Run& run = running_.front();
            if (!device::has_ended(run.end)) {
                const cl_int code = clWaitForEvents(1, &run.end());
                if (code != CL_SUCCESS && code != CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) return code;
            }
            if (!run.is_over()) keep_for_good(run);
        }
        return CL_SUCCESS;
    }

private:
    /// PoCL 3.1 ends the process in this case: a command fails, its event is released, and later an event of its wait
    /// list ends. So a run holds the events of its commands and of their wait list. It is removed when all have ended.
    struct Run {
        cl::Event end;
        std::vector<cl::Event> events;  // of the commands, and those that they waited for

        bool is_over() const { return std::all_of(events.begin(), events.end(), device::has_ended); }
    };
    std::deque<Run> running_;  // in their order
};

}  // namespace clsdf::transform

#pragma once

#include "device/opencl.hpp"

#include <deque>
#include <utility>
#include <vector>

namespace clsdf::transform {

/// Computations of a plan that may be unfinished. If a computation fails, it ends at once, even before the ones that it
/// waits for. So the end of the latest does not mean that all have ended.
class Runs {
public:
    /// commands: those before the end. Their events are held until the run ends: PoCL 3.1 aborts if an event fails
    /// while released events wait for it.
    void add(cl::Event end, std::vector<cl::Event> commands = {}) {
        forget_ended();
        running_.push_back({std::move(end), std::move(commands)});
    }

    /// The event that the next computation must wait for: the latest that has not ended. Null if all have ended.
    cl::Event latest() {
        forget_ended();
        return running_.empty() ? cl::Event() : running_.back().end;
    }

    /// Waits for all of them, whether they fail or not. Returns the error of a wait that could not be made.
    cl_int wait() noexcept {
        for (; !running_.empty(); running_.pop_front()) {
            if (device::has_ended(running_.front().end)) continue;
            const cl_int code = clWaitForEvents(1, &running_.front().end());
            if (code != CL_SUCCESS && code != CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) return code;
        }
        return CL_SUCCESS;
    }

private:
    void forget_ended() {
        while (!running_.empty() && device::has_ended(running_.front().end)) running_.pop_front();
        while (!running_.empty() && device::has_ended(running_.back().end)) running_.pop_back();
    }

    struct Run {
        cl::Event end;
        std::vector<cl::Event> commands;
    };
    std::deque<Run> running_;  // in their order
};

}  // namespace clsdf::transform

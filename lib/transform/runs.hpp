#pragma once

#include "device/opencl.hpp"

#include <deque>
#include <utility>

namespace clsdf::transform {

/// The computations of a plan that may still be under way. One that fails ends at once, also before those that it was
/// to follow: so the latest alone does not tell whether all have ended.
class Runs {
public:
    void add(cl::Event end) {
        forget_ended();
        running_.push_back(std::move(end));
    }

    /// What the next one is to wait for: the end of the latest that has not ended; null if all have.
    cl::Event latest() {
        forget_ended();
        return running_.empty() ? cl::Event() : running_.back();
    }

    /// Waits for all of them, whether they fail or not. Returns the error of a wait that could not be made.
    cl_int wait() noexcept {
        for (; !running_.empty(); running_.pop_front()) {
            if (device::has_ended(running_.front())) continue;
            const cl_int code = clWaitForEvents(1, &running_.front()());
            if (code != CL_SUCCESS && code != CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) return code;
        }
        return CL_SUCCESS;
    }

private:
    void forget_ended() {
        while (!running_.empty() && device::has_ended(running_.front())) running_.pop_front();
        while (!running_.empty() && device::has_ended(running_.back())) running_.pop_back();
    }

    std::deque<cl::Event> running_;  // in their order
};

}  // namespace clsdf::transform

#pragma once

#include "device/opencl.hpp"

namespace clsdf::device {

/// Whether a command has ended, well or not, without waiting for it; an event that is null has none. False if that
/// cannot be found out.
inline bool has_ended(const cl::Event& event) noexcept {
    cl_int status = CL_QUEUED;
    return event() == nullptr ||
           (clGetEventInfo(event(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr) == CL_SUCCESS &&
            status <= CL_COMPLETE);
}

/// Waits for a command, unless it is known to have ended well. Throws cl::Error if it has failed.
inline void wait_for(const cl::Event& event) {
    cl_int status = CL_QUEUED;
    if (clGetEventInfo(event(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr) == CL_SUCCESS &&
        status == CL_COMPLETE)
        return;
    event.wait();
}

}  // namespace clsdf::device

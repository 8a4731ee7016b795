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

}  // namespace clsdf::device

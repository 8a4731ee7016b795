#pragma once

#include <clsdf/export.hpp>

#include <stdexcept>
#include <string>

namespace clsdf {

/// The kind of a failure, for programs that act on it without reading the message.
enum class ErrorCode {
    invalid_mesh,      ///< index out of range, non-finite vertex in use, no triangle, sign rule that is not met
    unreadable_input,  ///< a file that cannot be opened, is truncated or malformed
    invalid_argument,  ///< a grid, band or option that makes no sense
    no_device,         ///< no OpenCL device, or none of the name asked for
    device_failure,    ///< an OpenCL call failed (message: call, code, build log), or the device computes wrong values
    out_of_memory,     ///< host or device memory, or the device's largest allocation, is too small
    unsupported,       ///< a correct request that this build or device does not support
    cancelled,         ///< should_stop returned true
    output_failure,    ///< a result could not be written; nothing is left under its final name
};

/// The exception of the library. The message names the thing, the value and the remedy.
class CLSDF_VISIBLE Error : public std::runtime_error {
public:
    Error(ErrorCode code, const std::string& message, int opencl_code = 0)
        : std::runtime_error(message), code_(code), opencl_code_(opencl_code) {}

    ErrorCode code() const noexcept { return code_; }
    /// The cl_int that the failed OpenCL call returned; 0 (CL_SUCCESS) for other errors.
    int opencl_code() const noexcept { return opencl_code_; }

private:
    ErrorCode code_;
    int opencl_code_;
};

}  // namespace clsdf

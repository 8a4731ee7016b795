#pragma once

#include <clsdf/export.hpp>

#include <cstdint>
#include <stdexcept>
#include <string>

namespace clsdf {

/// The kind of a failure, for programs that act on it without reading the message. A number never changes its meaning,
/// so other languages may use them; 0 is no error. Later versions may add numbers.
enum class ErrorCode : std::int32_t {
    invalid_mesh = 1,      ///< index out of range, non-finite vertex in use, no triangle, sign rule that is not met
    unreadable_input = 2,  ///< a file that cannot be opened, is truncated or malformed
    invalid_argument = 3,  ///< a grid, band or option that makes no sense
    no_device = 4,         ///< no OpenCL device, or none of the name asked for
    device_failure = 5,    ///< an OpenCL call failed; the message has the call, its code and a compiler's log
    out_of_memory = 6,     ///< host or device memory, or the device's largest allocation, is too small
    unsupported = 7,       ///< a correct request that this build or device does not support
    cancelled = 8,         ///< should_stop returned true
    output_failure = 9,    ///< a result could not be written; nothing is left under its final name
    wrong_results = 10,    ///< the device's programs compute wrong values in the test at their first use
};

/// The enumerator's name: "invalid_mesh". "unknown" for a number that this version does not have. The text lives as
/// long as the process. Thread-safe.
CLSDF_EXPORT const char* name_of(ErrorCode code) noexcept;

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

#pragma once

#include <clsdf/error.hpp>

#include "device/opencl_binding.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace clsdf {
enum class KernelBody;  // clsdf/tuning.hpp
}

namespace clsdf::device {

/// "CL_OUT_OF_RESOURCES" for -5, and so on.
std::string code_name(cl_int code);

/// The name of the call that failed: the C++ binding misspells some.
std::string call_name(const cl::Error& error);

/// The call that failed and its code's name, as clsdf::Error: out_of_memory for memory, else device_failure.
[[noreturn]] void throw_device_error(const cl::Error& error);

/// Runs OpenCL calls; their errors become clsdf::Error.
template <class Function>
decltype(auto) guarded(Function&& function) {
    try {
        return std::forward<Function>(function)();
    } catch (const cl::Error& error) {
        throw_device_error(error);
    }
}

/// Whether a command has ended, well or not, without waiting for it; an event that is null has none. False if that
/// cannot be found out.
inline bool has_ended(const cl::Event& event) noexcept {
    cl_int status = CL_QUEUED;
    return event() == nullptr ||
           (clGetEventInfo(event(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr) == CL_SUCCESS &&
            status <= CL_COMPLETE);
}

/// A command of the device has failed: err() is the status of its event. Drivers give a command that did not run,
/// because one before it has failed, a status of its own.
class CommandError : public cl::Error {
public:
    explicit CommandError(cl_int status) : cl::Error(status, "clWaitForEvents") {}
};

/// Waits for a command, also if it has ended. Throws CommandError if it has failed.
void wait_until_ended(const cl::Event& event);

/// The same, but does not ask the driver to wait if the command is known to have ended. For a command that the driver
/// has waited for already: blocking calls, and waits for the queue, do not fail with PoCL if a command has failed.
void wait_for(const cl::Event& event);

/// Reads from a buffer when the commands before in the queue and `before`, which may be null, have ended. Throws
/// CommandError if one of them has failed, and cl::Error.
void read_blocking(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
                   void* to, const cl::Event& before = {});

/// The names and versions by which faults are known, as OpenCL reports them.
struct Implementation {
    std::string platform;      ///< CL_PLATFORM_NAME
    std::string version;       ///< CL_PLATFORM_VERSION; PoCL's names its LLVM, too
    std::string device;        ///< CL_DEVICE_NAME
    unsigned float_width = 1;  ///< CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT
};

Implementation implementation_of(const cl::Device& device);

/// Platform and version, e.g. "Portable Computing Language" (OpenCL 3.0 PoCL 3.0 ...).
std::string text_of(const Implementation& implementation);

/// A fault of an OpenCL implementation that no change of the kernels avoids. All texts must be part of the
/// implementation's own; an empty one always is.
struct KnownFault {
    std::string_view platform;
    std::array<std::string_view, 2> version;
    std::string_view device;
    unsigned least_float_width;
    KernelBody body;           ///< that fails
    std::string_view symptom;  ///< what happens: "<implementation> ..."
    std::string_view remedy;   ///< what the user can do
};

/// "by_vector" or "by_group".
const char* name_of(KernelBody body);

/// The fault that this kernel body meets on this implementation, or null.
const KnownFault* known_fault(const Implementation& implementation, KernelBody body);

/// Throws Error(unsupported) with device, version, symptom and remedy if there is such a fault. Called before the first
/// program of a kernel body is built, because a compiler that fails may end the process.
void refuse_known_fault(const cl::Device& device, KernelBody body);

/// Build options, beginning with a space, that work around what this implementation makes wrong of a kernel file;
/// mostly empty. The bytes of fields are those of other implementations.
std::string_view options_around_faults(const Implementation& implementation, std::string_view kernel_file);

}  // namespace clsdf::device

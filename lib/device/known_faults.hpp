#pragma once

#include "device/opencl.hpp"

#include <array>
#include <string>
#include <string_view>

namespace clsdf::device {

/// The names and versions by which faults are known, as OpenCL reports them.
struct Implementation {
    std::string platform;      ///< CL_PLATFORM_NAME
    std::string version;       ///< CL_PLATFORM_VERSION; PoCL's names its LLVM, too
    std::string device;        ///< CL_DEVICE_NAME
    unsigned float_width = 1;  ///< CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT
};

Implementation implementation_of(const cl::Device& device);

/// A fault of an OpenCL implementation that no change of the kernels avoids. All texts must be part of the
/// implementation's own; an empty one always is.
struct KnownFault {
    std::string_view platform;
    std::array<std::string_view, 2> version;
    std::string_view device;
    unsigned least_float_width;
    std::string_view body;     ///< the kernel body that fails: "by_vector" or "by_group"; empty: both
    std::string_view symptom;  ///< what happens: "<implementation> ..."
    std::string_view remedy;   ///< what the user can do
};

/// The fault that this kernel body meets on this implementation, or null.
const KnownFault* known_fault(const Implementation& implementation, std::string_view body);

/// Throws Error(unsupported) with device, version, symptom and remedy if there is such a fault. Called before the first
/// program of a kernel body is built, because a compiler that fails may end the process.
void refuse_known_fault(const cl::Device& device, std::string_view body);

/// Build options, beginning with a space, that work around what this implementation makes wrong of a kernel file;
/// mostly empty. The bytes of fields are those of other implementations.
std::string_view options_around_faults(const Implementation& implementation, std::string_view kernel_file);

}  // namespace clsdf::device

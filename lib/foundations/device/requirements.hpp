#pragma once

#include "device/opencl.hpp"

#include <string>

namespace clsdf::device {

/// Whether a device lists an extension. Throws cl::Error.
bool has_extension(const cl::Device& device, const std::string& name);

/// Throws cl::Error.
bool has_double_precision(const cl::Device& device);

/// "it has OpenCL 1.1, and 1.2 is needed" of a device that is older; else empty. Throws cl::Error.
std::string too_old(const cl::Device& device);

/// too_old(), or why a device cannot compute in double, with a remedy; else empty. Throws cl::Error.
std::string missing_feature(const cl::Device& device);

}  // namespace clsdf::device

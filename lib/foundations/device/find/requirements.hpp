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

/// Whether Intel made the device. Throws cl::Error.
bool is_of_intel(const cl::Device& device);

/// Why a device is used only if it is named, with a remedy: its driver emulates double precision, or may do so. Empty
/// of other devices, and of those without double precision. Throws cl::Error.
///
/// A GPU of Intel says that it has double precision, and its generation, by its PCI number, has none: it is emulated.
/// If the generation is unknown, the variables decide by which Intel's driver is told to emulate.
std::string emulated_doubles(const cl::Device& device);

/// Which drivers there are: a remedy.
inline constexpr const char* how_to_install =
    "install an OpenCL driver: for any processor PoCL (Debian: apt install pocl-opencl-icd); for a GPU its maker's, "
    "nvidia-opencl-icd (NVIDIA), intel-opencl-icd (Intel), rocm-opencl-icd (AMD, from Debian 13 on) or AMD's own ROCm";

}  // namespace clsdf::device

#pragma once

#include "device/opencl_binding.hpp"

#include <clsdf/export.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace clsdf::device {

/// The driver for processors that a package brings with it: PoCL without a compiler, libclsdf_pocl.so, and clsdf's
/// programs, compiled ahead for each level of processors, programs/<level>/*.program.
///
/// Its folder is `driver` beside the folder of the file that contains this library, a program or a shared library:
/// PREFIX/driver for PREFIX/lib/libclsdf.so. Only builds with the option CLSDF_BUNDLED_DRIVER look there.
/// tuning_variable("CLSDF_DRIVER") names another folder.
///
/// A process has one, so a shared core exports these functions (see cmake/Libraries.cmake).
struct BundledDriver {
    std::filesystem::path folder;  ///< empty if there is none
    std::filesystem::path file;    ///< likewise
    cl::Platform platform;         ///< null if there is none, or if it cannot be opened
    std::string why_not;           ///< why it cannot be opened
};

/// Opens it at the first call. Needs no environment variable, and no driver that OpenCL's loader knows.
CLSDF_EXPORT const BundledDriver& bundled_driver();

/// Whether it is a device of the bundled driver, or a part of one. False if the driver was not opened. Throws
/// cl::Error.
CLSDF_EXPORT bool is_bundled(const cl::Device& device);

/// The folder of the programs of a bundled device, which is that of its processor's level; empty if there is none.
/// Throws cl::Error.
CLSDF_EXPORT std::filesystem::path bundled_programs(const cl::Device& device);

/// A level of processors for which the bundled driver has programs.
struct BundledLevel {
    std::string name;  ///< x86-64-v3
    std::filesystem::path folder;
    std::string target;  ///< target_of() a device of this level
};
/// All of them; `device` is the bundled one. Throws cl::Error.
CLSDF_EXPORT std::vector<BundledLevel> bundled_levels(const cl::Device& device);

/// CL_PLATFORM_NAME of a device; that of the bundled driver, which is PoCL's, with an addition. Throws cl::Error.
CLSDF_EXPORT std::string platform_name(const cl::Device& device);

}  // namespace clsdf::device

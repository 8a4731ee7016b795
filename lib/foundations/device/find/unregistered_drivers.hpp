#pragma once

#include "device/opencl_binding.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace clsdf::device {

/// The driver of a maker of GPUs that OpenCL's loader may not know. In containers NVIDIA's often lies among the
/// system's libraries and has no file in /etc/OpenCL/vendors.
struct UnregisteredDriver {
    std::string maker;
    std::filesystem::path gpu;  ///< the GPU's file in /dev; empty if none is there that is this maker's alone
    std::filesystem::path file;
    std::vector<cl::Platform> platforms;  ///< the loader may know them
    std::string why_not;                  ///< why it cannot be opened, with a remedy
};

/// NVIDIA's driver if /dev/nvidia<N> is there, AMD's if /dev/kfd is there, and those and Intel's if a render node is
/// there, /dev/dri/renderD<N>. A driver is looked for and opened once (system_libraries(), open_driver()).
/// tuning_variable("CLSDF_DEVICE_FILES") names another folder than /dev.
///
/// None if OCL_ICD_VENDORS or OPENCL_VENDOR_PATH is set: then the user has chosen what the loader sees.
std::vector<UnregisteredDriver> unregistered_drivers();

}  // namespace clsdf::device

#include "device/find/requirements.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace clsdf::device {

bool has_extension(const cl::Device& device, const std::string& name) {
    return (' ' + device.getInfo<CL_DEVICE_EXTENSIONS>() + ' ').find(' ' + name + ' ') != std::string::npos;
}

bool has_double_precision(const cl::Device& device) {
    cl_device_fp_config config = 0;
    const cl_int code = clGetDeviceInfo(device(), CL_DEVICE_DOUBLE_FP_CONFIG, sizeof config, &config, nullptr);
    // Drivers may refuse the question if there is no double precision.
    if (code == CL_INVALID_VALUE) return has_extension(device, "cl_khr_fp64");
    if (code != CL_SUCCESS) throw cl::Error(code, "clGetDeviceInfo");
    return config != 0;
}

std::string too_old(const cl::Device& device) {
    // "OpenCL <major>.<minor> <the driver's own text>"
    const std::string version = device.getInfo<CL_DEVICE_VERSION>();
    int major = 0, minor = 0;
    if (std::sscanf(version.c_str(), "OpenCL %d.%d", &major, &minor) != 2 || std::pair(major, minor) >= std::pair(1, 2))
        return {};
    return fmt::format("it has OpenCL {}.{}, and 1.2 is needed", major, minor);
}

std::string missing_feature(const cl::Device& device) {
    if (std::string reason = too_old(device); !reason.empty()) return reason;
    if (has_double_precision(device)) return {};
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    const bool is_rusticl = platform.getInfo<CL_PLATFORM_NAME>() == "rusticl";
    return std::string("it has no double precision (cl_khr_fp64)") +
           (is_rusticl ? "; from Mesa 23.2 on, RUSTICL_FEATURES=fp64 in the environment enables it, as an experiment"
                       : "");
}

}  // namespace clsdf::device

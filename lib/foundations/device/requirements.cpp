#include "device/requirements.hpp"

#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <system_error>

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
    constexpr std::string_view prefix = "OpenCL ";
    if (!version.starts_with(prefix)) return {};
    const char* const end = version.data() + version.size();
    int major = 0, minor = 0;
    const auto [point, error] = std::from_chars(version.data() + prefix.size(), end, major);
    if (error != std::errc() || point == end || *point != '.' ||
        std::from_chars(point + 1, end, minor).ec != std::errc())
        return {};
    if (major > 1 || (major == 1 && minor >= 2)) return {};
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

#include <clsdf/device.hpp>

#include "device/context.hpp"
#include "device/known_faults.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// Throws cl::Error.
std::vector<cl::Platform> all_platforms() {
    std::vector<cl::Platform> platforms;
    try {
        cl::Platform::get(&platforms);
    } catch (const cl::Error& error) {
        constexpr cl_int no_platform = -1001;  // CL_PLATFORM_NOT_FOUND_KHR of the loader
        if (error.err() != no_platform) throw;
    }
    return platforms;
}

std::string failure(const cl::Error& error) {
    return fmt::format("it fails at {}: {}", device::call_name(error), device::code_name(error.err()));
}

/// Throws cl::Error.
std::vector<cl::Device> devices_of(const cl::Platform& platform) {
    std::vector<cl::Device> devices;
    try {
        platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
    } catch (const cl::Error& error) {
        if (error.err() != CL_DEVICE_NOT_FOUND) throw;
    }
    return devices;
}

/// In place of the devices that a platform does not tell.
DeviceInfo info_of_failing(const cl::Platform& platform, const cl::Error& error) {
    DeviceInfo info;
    info.name = "devices of a platform";
    info.why_not = failure(error);
    try {
        info.platform = platform.getInfo<CL_PLATFORM_NAME>();
        info.name = fmt::format("devices of {}", info.platform);
    } catch (const cl::Error&) {
        // It stays without a name.
    }
    return info;
}

DeviceKind kind_of(const cl::Device& device) {
    const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
    if ((type & CL_DEVICE_TYPE_GPU) != 0) return DeviceKind::gpu;
    if ((type & CL_DEVICE_TYPE_CPU) != 0) return DeviceKind::processor;
    if ((type & CL_DEVICE_TYPE_ACCELERATOR) != 0) return DeviceKind::accelerator;
    return DeviceKind::other;
}

bool has_extension(const cl::Device& device, const std::string& name) {
    return (' ' + device.getInfo<CL_DEVICE_EXTENSIONS>() + ' ').find(' ' + name + ' ') != std::string::npos;
}

/// Throws cl::Error, as devices with a broken driver do; what was learnt until then stays.
void ask(const cl::Device& device, DeviceInfo& info) {
    info.name = device.getInfo<CL_DEVICE_NAME>();
    info.platform = cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>();
    info.version = device.getInfo<CL_DEVICE_VERSION>();
    info.driver = device.getInfo<CL_DRIVER_VERSION>();
    info.kind = kind_of(device);
    const device::Context::Capabilities capabilities = device::capabilities_of(device);
    info.compute_units = capabilities.compute_units;
    info.clock_megahertz = device.getInfo<CL_DEVICE_MAX_CLOCK_FREQUENCY>();
    info.memory = capabilities.memory;
    info.largest_allocation = capabilities.largest_allocation;
    info.float_width = capabilities.float_width;
    info.atomics64 = has_extension(device, "cl_khr_int64_base_atomics");
    info.fp64 = device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0;
    if (!info.fp64)
        info.why_not = "it has no double precision (cl_khr_fp64)";
    else if (device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>() == 0)
        info.why_not = "its driver has no compiler";
    else if (device.getInfo<CL_DEVICE_AVAILABLE>() == 0)
        info.why_not = "its driver says that it is not available";
    else if (const device::KnownFault* fault = device::known_fault(
                 device::implementation_of(device), capabilities.is_processor ? "by_vector" : "by_group"))
        info.why_not = fmt::format("it {}; {}", fault->symptom, fault->remedy);
}

DeviceInfo info_of(const cl::Device& device) {
    DeviceInfo info;
    info.id = device();
    try {
        ask(device, info);
    } catch (const cl::Error& error) {
        info.why_not = failure(error);
    }
    return info;
}

}  // namespace

std::string name_of(DeviceKind kind) {
    switch (kind) {
        case DeviceKind::gpu:
            return "gpu";
        case DeviceKind::processor:
            return "processor";
        case DeviceKind::accelerator:
            return "accelerator";
        default:
            return "other";
    }
}

std::vector<DeviceInfo> Device::all() {
    std::vector<DeviceInfo> infos;
    for (const cl::Platform& platform : device::guarded(all_platforms)) {
        try {
            for (const cl::Device& device : devices_of(platform)) infos.push_back(info_of(device));
        } catch (const cl::Error& error) {
            infos.push_back(info_of_failing(platform, error));
        }
    }
    for (std::size_t index = 0; index < infos.size(); ++index) infos[index].index = index;
    return infos;
}

}  // namespace clsdf

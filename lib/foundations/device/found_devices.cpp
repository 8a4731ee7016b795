#include "device/found_devices.hpp"

#include <clsdf/tuning.hpp>

#include "device/bundled_driver.hpp"
#include "device/context.hpp"
#include "device/opencl.hpp"
#include "device/prepared_programs.hpp"
#include "device/requirements.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>

namespace clsdf::device {

namespace {

/// Throws cl::Error.
std::vector<cl::Platform> all_platforms() {
    std::vector<cl::Platform> platforms;
    try {
        cl::Platform::get(&platforms);
    } catch (const cl::Error& error) {
        constexpr cl_int no_platform = -1001;  // CL_PLATFORM_NOT_FOUND_KHR
        if (error.err() != no_platform) throw;
    }
    return platforms;
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

DeviceKind kind_of(const cl::Device& device) {
    const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
    if ((type & CL_DEVICE_TYPE_GPU) != 0) return DeviceKind::gpu;
    if ((type & CL_DEVICE_TYPE_CPU) != 0) return DeviceKind::processor;
    if ((type & CL_DEVICE_TYPE_ACCELERATOR) != 0) return DeviceKind::accelerator;
    return DeviceKind::other;
}

void refuse(FoundDevice& found, Obstacle obstacle, std::string why_not) {
    found.info.why_not = std::move(why_not);
    found.obstacle = found.info.why_not.empty() ? Obstacle::none : obstacle;
}

/// A device whose driver fails. Its name may be unknown, and its platform's too.
void refuse(FoundDevice& found, const cl::Platform& platform, const cl::Error& error) {
    refuse(found, Obstacle::failing_call, fmt::format("it fails at {}: {}", call_name(error), code_name(error.err())));
    DeviceInfo& info = found.info;
    try {
        if (info.platform.empty()) info.platform = platform.getInfo<CL_PLATFORM_NAME>();
    } catch (const cl::Error&) {
        // It stays without a name.
    }
    if (info.name.empty())
        info.name = fmt::format("a device of {}", info.platform.empty() ? "a platform without a name" : info.platform);
}

/// Throws cl::Error, as devices with a broken driver do; the properties that are known by then are kept.
void ask(const cl::Device& device, FoundDevice& found) {
    DeviceInfo& info = found.info;
    info.name = device.getInfo<CL_DEVICE_NAME>();
    info.platform = platform_name(device);
    info.version = device.getInfo<CL_DEVICE_VERSION>();
    info.driver = device.getInfo<CL_DRIVER_VERSION>();
    info.kind = kind_of(device);
    refuse(found, Obstacle::missing_feature, too_old(device));
    info.atomics64 = has_extension(device, "cl_khr_int64_base_atomics");
    info.fp64 = has_double_precision(device);
    info.clock_megahertz = device.getInfo<CL_DEVICE_MAX_CLOCK_FREQUENCY>();
    const Context::Capabilities capabilities = capabilities_of(device);
    info.compute_units = capabilities.compute_units;
    info.memory = capabilities.memory;
    info.largest_allocation = capabilities.largest_allocation;
    info.float_width = capabilities.float_width;
    refuse(found, Obstacle::missing_feature, missing_feature(device));
    if (!info.usable()) return;
    if (capabilities.largest_group < 64)
        refuse(found, Obstacle::missing_feature,
               fmt::format("its work-groups have {} items at most, and kernels need 64", capabilities.largest_group));
    else if (is_bundled(device) && bundled_programs(device).empty())
        refuse(found, Obstacle::missing_feature,
               fmt::format("{} has no programs for this processor, {}", bundled_driver().folder.string(),
                           processor_level(device)));
    else if (!is_bundled(device) && device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>() == 0)
        refuse(found, Obstacle::missing_feature, "its driver has no compiler");
    else if (device.getInfo<CL_DEVICE_AVAILABLE>() == 0)
        refuse(found, Obstacle::missing_feature, "its driver says that it is not available");
    else if (const Implementation implementation = implementation_of(device);
             const KnownFault* fault =
                 known_fault(implementation, capabilities.is_processor ? KernelBody::by_vector : KernelBody::by_group))
        refuse(found, Obstacle::known_fault,
               fmt::format("{} {}; {}", text_of(implementation), fault->symptom, fault->remedy));
}

FoundDevice found_device(const cl::Platform& platform, const cl::Device& device) {
    FoundDevice found;
    found.info.id = device();
    try {
        ask(device, found);
    } catch (const cl::Error& error) {
        // A driver that is too old knows fewer properties.
        if (found.info.usable()) refuse(found, platform, error);
    }
    return found;
}

void append_devices(const cl::Platform& platform, std::vector<FoundDevice>& all) {
    try {
        for (const cl::Device& device : devices_of(platform)) all.push_back(found_device(platform, device));
    } catch (const cl::Error& error) {
        refuse(all.emplace_back(), platform, error);
    }
}

}  // namespace

std::vector<FoundDevice> find_installed_devices() {
    std::vector<FoundDevice> found;
    for (const cl::Platform& platform : all_platforms()) append_devices(platform, found);
    return found;
}

std::vector<FoundDevice> find_bundled_devices() {
    std::vector<FoundDevice> found;
    const BundledDriver& driver = bundled_driver();
    if (driver.platform() != nullptr) append_devices(driver.platform, found);
    if (!driver.why_not.empty()) {
        FoundDevice& none = found.emplace_back();
        none.info.name = "the driver bundled with clsdf";
        refuse(none, Obstacle::missing_feature, driver.why_not);
    }
    return found;
}

std::vector<FoundDevice> find_devices() {
    std::vector<FoundDevice> all = find_installed_devices(), bundled = find_bundled_devices();
    std::move(bundled.begin(), bundled.end(), std::back_inserter(all));
    for (std::size_t index = 0; index < all.size(); ++index) all[index].info.index = index;
    return all;
}

DeviceInfo info_of(const cl::Device& device) {
    DeviceInfo info = found_device(cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>()), device).info;
    for (const FoundDevice& found : find_devices())
        if (found.info.id == info.id) info.index = found.info.index;
    return info;
}

std::string empty_platforms() {
    std::string text;
    try {
        for (const cl::Platform& platform : all_platforms()) {
            if (!devices_of(platform).empty()) continue;
            const std::string name = platform.getInfo<CL_PLATFORM_NAME>();
            text += fmt::format("; the platform \"{}\" has no devices", name);
            if (name == "rusticl")
                text +=
                    ": it shows GPUs if RUSTICL_ENABLE=radeonsi (AMD), iris (Intel) or nouveau (NVIDIA) is in the "
                    "environment";
            if (name == "Portable Computing Language")
                text +=
                    ": PoCL shows none if it cannot write its cache; name a folder that it can write to in "
                    "POCL_CACHE_DIR, or in HOME";
        }
    } catch (const cl::Error&) {
        // Further platforms are not named.
    }
    if (text.empty()) return text;
    return text +
           "; a GPU needs access to the files in /dev/dri (AMD's also to /dev/kfd); on most systems, join the group "
           "render";
}

}  // namespace clsdf::device

#include "device/find/found_devices.hpp"

#include <clsdf/tuning.hpp>

#include "device/context.hpp"
#include "device/find/bundled_driver.hpp"
#include "device/find/requirements.hpp"
#include "device/find/unregistered_drivers.hpp"
#include "device/opencl.hpp"
#include "device/prepared_programs.hpp"

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string_view>

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
    if (info.usable()) info.only_if_named = emulated_doubles(device);
}

FoundDevice found_device(const cl::Platform& platform, const cl::Device& device) {
    FoundDevice found;
    found.info.id = device();
    found.platform = platform;
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
        all.emplace_back().platform = platform;
        refuse(all.back(), platform, error);
    }
}

bool has_gpu_to_take(const std::vector<FoundDevice>& all) {
    return std::ranges::any_of(
        all, [](const FoundDevice& found) { return found.info.may_be_taken() && found.info.kind == DeviceKind::gpu; });
}

bool contains(const std::vector<cl::Platform>& platforms, const cl::Platform& platform) {
    return std::ranges::any_of(platforms, [&](const cl::Platform& one) { return one() == platform(); });
}

/// Notes who opened the driver of the devices from the one with this number on.
void set_source(std::vector<FoundDevice>& all, std::size_t first, DeviceSource source, const std::string& driver_file) {
    for (std::size_t n = first; n < all.size(); ++n) {
        all[n].info.source = source;
        all[n].info.driver_file = driver_file;
    }
}

/// Why the GPU of this driver's maker cannot be used.
std::string why_unused(const UnregisteredDriver& driver, const std::vector<FoundDevice>& all) {
    for (const FoundDevice& found : all) {
        const DeviceInfo& info = found.info;
        const bool is_makers =
            contains(driver.platforms, found.platform) || info.platform.find(driver.maker) != std::string::npos;
        if (is_makers && !info.usable()) return fmt::format("\"{}\" cannot be used: {}", info.name, info.why_not);
    }
    if (!driver.why_not.empty()) return driver.why_not;
    return fmt::format(
        "its driver, {}, shows no device that can be used; update the driver if the maker's own tool "
        "shows one",
        driver.file.string());
}

/// A GPU of which there is a file in /dev, and no device that can be used.
FoundDevice unused_gpu(const UnregisteredDriver& driver, const std::vector<FoundDevice>& all) {
    FoundDevice found;
    found.info.name = fmt::format("a GPU of {}", driver.maker);
    found.info.source = DeviceSource::device_file;
    found.info.driver_file = driver.gpu.string();
    std::string why_not = why_unused(driver, all);
    if (::access(driver.gpu.c_str(), R_OK | W_OK) != 0)
        why_not +=
            fmt::format("; this user may not open {}: join its group, mostly render or video", driver.gpu.string());
    refuse(found, Obstacle::missing_feature, why_not);
    return found;
}

}  // namespace

std::vector<FoundDevice> find_registered_devices() {
    std::vector<FoundDevice> found;
    for (const cl::Platform& platform : all_platforms()) append_devices(platform, found);
    return found;
}

std::vector<FoundDevice> find_unregistered_devices(const std::vector<FoundDevice>& registered) {
    std::vector<FoundDevice> found;
    if (has_gpu_to_take(registered)) return found;
    const std::vector<UnregisteredDriver> drivers = unregistered_drivers();
    if (drivers.empty()) return found;
    const std::vector<cl::Platform> listed = all_platforms();
    for (const UnregisteredDriver& driver : drivers)
        for (const cl::Platform& platform : driver.platforms) {
            if (contains(listed, platform)) continue;
            const std::size_t first = found.size();
            append_devices(platform, found);
            set_source(found, first, DeviceSource::unregistered, driver.file.string());
        }
    if (has_gpu_to_take(found)) return found;
    std::vector<FoundDevice> all = registered;
    all.insert(all.end(), found.begin(), found.end());
    for (const UnregisteredDriver& driver : drivers)
        if (!driver.gpu.empty()) found.push_back(unused_gpu(driver, all));
    return found;
}

std::vector<FoundDevice> find_installed_devices() {
    std::vector<FoundDevice> all = find_registered_devices(), unregistered = find_unregistered_devices(all);
    std::move(unregistered.begin(), unregistered.end(), std::back_inserter(all));
    return all;
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
    set_source(found, 0, DeviceSource::bundled, driver.file.string());
    return found;
}

std::vector<FoundDevice> find_devices() {
    std::vector<FoundDevice> all = find_registered_devices(), bundled = find_bundled_devices();
    // These come last, so that the numbers of the others stay when such a driver is installed.
    std::vector<FoundDevice> unregistered = find_unregistered_devices(all);
    std::move(bundled.begin(), bundled.end(), std::back_inserter(all));
    std::move(unregistered.begin(), unregistered.end(), std::back_inserter(all));
    for (std::size_t index = 0; index < all.size(); ++index) all[index].info.index = index;
    return all;
}

DeviceInfo info_of(const cl::Device& device) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    DeviceInfo info = found_device(platform, device).info;
    for (const FoundDevice& found : find_devices()) {
        if (found.platform() != platform()) continue;
        info.source = found.info.source;
        info.driver_file = found.info.driver_file;
        if (found.info.id == info.id) info.index = found.info.index;
    }
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

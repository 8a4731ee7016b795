#pragma once

#include "device/opencl_binding.hpp"

#include <clsdf/device.hpp>

#include <string>
#include <vector>

namespace clsdf::device {

/// Why a device cannot be used; the remedy depends on it.
enum class Obstacle {
    none,
    missing_feature,  ///< another driver may have the feature, or another device
    known_fault,      ///< why_not names the remedy
    failing_call,     ///< a question to the driver fails
};

struct FoundDevice {
    DeviceInfo info;
    Obstacle obstacle = Obstacle::none;
    cl::Platform platform{};  ///< null if it has none
};

/// Every device of every platform, in the order of OpenCL's loader. A platform that does not list its devices has one
/// entry without `id`. `index` is not set. Throws cl::Error if the platforms cannot be listed.
std::vector<FoundDevice> find_registered_devices();
/// Those of unregistered_drivers(), likewise, without platforms that the loader lists; none if a registered GPU may be
/// taken. If none of them may be taken, either, a GPU's file in /dev has an entry without `id`. Throws cl::Error.
std::vector<FoundDevice> find_unregistered_devices(const std::vector<FoundDevice>& registered);
/// The device of the bundled driver, likewise. A driver that cannot be opened has one entry without `id`.
std::vector<FoundDevice> find_bundled_devices();
/// Those of drivers that are on this machine: registered, then unregistered ones. Throws cl::Error.
std::vector<FoundDevice> find_installed_devices();
/// Registered devices, the bundled one, unregistered ones, with `index`. Throws cl::Error.
std::vector<FoundDevice> find_devices();

/// The entry of one device; `index` is DeviceInfo::not_listed if find_devices() has no device of this id. Throws
/// cl::Error.
DeviceInfo info_of(const cl::Device& device);

/// Platforms without devices, each with a remedy, as the end of a sentence; empty if there are none.
std::string empty_platforms();

}  // namespace clsdf::device

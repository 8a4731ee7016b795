#pragma once

#include "device/opencl_binding.hpp"

#include <filesystem>
#include <vector>

namespace clsdf::device {

/// Opens a driver by its path, beside OpenCL's loader, and keeps it open: its threads may run until the process ends.
/// The loader's functions find a driver's own by the dispatch table to which each of its objects points (cl_khr_icd),
/// so they work for platforms that the loader did not list. A platform whose objects have no such table, or another one
/// than the platform, is refused. Throws Error(no_device) that says what is wrong with the driver; cl::Error.
std::vector<cl::Platform> open_driver(const std::filesystem::path& file);

}  // namespace clsdf::device

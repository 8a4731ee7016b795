#include "device/find/requirements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>
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

bool is_of_intel(const cl::Device& device) {
    constexpr cl_uint intel = 0x8086;
    return device.getInfo<CL_DEVICE_VENDOR_ID>() == intel;
}

namespace {

/// The upper bytes of the PCI numbers of Intel's GPUs, by intel/compute-runtime: shared/source/dll/devices/
/// devices_base.inl and ftrSupportsFP64, on master and, of Gen8 to Gen11, in releases/24.35.
constexpr std::array without_doubles{0x45U, 0x4EU, 0x8AU, 0x98U,             // Gen11
                                     0x46U, 0x49U, 0x4CU, 0x9AU, 0xA7U,      // Gen12 LP: Tiger to Raptor Lake, DG1
                                     0x4FU, 0x56U};                          // DG2: Arc A, Flex
constexpr std::array with_doubles{0x16U,                                     // Gen8
                                  0x0AU, 0x19U, 0x1AU, 0x31U, 0x3EU, 0x59U,  // Gen9, Gen9.5
                                  0x5AU, 0x87U, 0x99U, 0x9BU,                // the same
                                  0x0BU,                                     // Ponte Vecchio
                                  0x7DU,                                     // Meteor Lake, Arrow Lake
                                  0x64U, 0xE2U,                              // Lunar Lake, Battlemage
                                  0xB0U, 0xFDU,                              // Panther Lake, Wildcat Lake
                                  0x67U, 0xD7U};                             // Crescent Island, Nova Lake

/// Of a GPU of Intel, if its driver tells it: Intel's own does, since 2020 in the name ("Intel(R) Graphics [0x46a6]"),
/// since 2021 by cl_intel_device_attribute_query.
std::optional<unsigned> pci_number(const cl::Device& device) {
    constexpr cl_device_info question = 0x4251;  // CL_DEVICE_ID_INTEL
    cl_uint number = 0;
    if (has_extension(device, "cl_intel_device_attribute_query") &&
        clGetDeviceInfo(device(), question, sizeof number, &number, nullptr) == CL_SUCCESS)
        return number;
    const std::string name = device.getInfo<CL_DEVICE_NAME>();
    constexpr std::string_view prefix = "[0x";
    const std::size_t at = name.find(prefix);
    if (at == std::string::npos) return std::nullopt;
    const char* const end = name.data() + name.size();
    if (std::from_chars(name.data() + at + prefix.size(), end, number, 16).ec != std::errc()) return std::nullopt;
    return number;
}

/// Nothing of a GPU that the tables do not have.
std::optional<bool> has_own_doubles(std::optional<unsigned> pci_number) {
    if (!pci_number) return std::nullopt;
    const unsigned upper_byte = *pci_number >> 8U;
    if (std::ranges::count(with_doubles, upper_byte) > 0) return true;
    if (std::ranges::count(without_doubles, upper_byte) > 0) return false;
    return std::nullopt;
}

constexpr std::array<const char*, 3> emulating_variables{"OverrideDefaultFP64Settings", "IGC_EnableDPEmulation",
                                                         "NEO_FP64_EMULATION"};

bool is_set(const char* variable) {
    const char* const value = std::getenv(variable);
    return value != nullptr && *value != 0 && value != std::string_view("0");
}

}  // namespace

std::string emulated_doubles(const cl::Device& device) {
    const bool is_gpu = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
    if (!is_gpu || !is_of_intel(device) || !has_double_precision(device)) return {};
    const std::optional<bool> own_doubles = has_own_doubles(pci_number(device));
    const auto* const variable = std::ranges::find_if(emulating_variables, is_set);
    if (own_doubles.value_or(variable == emulating_variables.end())) return {};
    if (own_doubles)
        return "Intel's driver emulates its double precision, which can be wrong without an error; take another device";
    return fmt::format(
        "{} lets Intel's driver emulate double precision, which can be wrong without an error, and it is not known "
        "whether this GPU has its own; unset the variable, or take another device",
        *variable);
}

}  // namespace clsdf::device

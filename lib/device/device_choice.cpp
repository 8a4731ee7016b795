#include <clsdf/device.hpp>

#include "device/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <vector>

namespace clsdf {

namespace {

constexpr const char* how_to_install =
    "install an OpenCL driver: for any processor PoCL (Debian: apt install pocl-opencl-icd); for a GPU its maker's, "
    "nvidia-opencl-icd (NVIDIA), mesa-opencl-icd or ROCm (AMD), intel-opencl-icd (Intel)";

Error no_device_found() {
    return {ErrorCode::no_device, fmt::format("no OpenCL device was found; {}", how_to_install)};
}

Error not_selected(const std::string& reason, const std::vector<DeviceInfo>& infos) {
    std::string list;
    for (const DeviceInfo& info : infos)
        list += fmt::format("{}{}: \"{}\" ({})", list.empty() ? "" : ", ", info.index, info.name, info.platform);
    return {ErrorCode::no_device, fmt::format("{}; the devices are {}", reason, list)};
}

/// GPUs before everything else, then by compute units times clock, a stand-in for speed.
bool is_stronger(const DeviceInfo& one, const DeviceInfo& other) {
    const bool gpu = one.kind == DeviceKind::gpu;
    if (gpu != (other.kind == DeviceKind::gpu)) return gpu;
    const auto rate = [](const DeviceInfo& info) { return 1.0 * info.compute_units * info.clock_megahertz; };
    return rate(one) > rate(other);
}

/// Usable devices, the strongest first.
std::vector<DeviceInfo> candidates(std::vector<DeviceInfo> infos) {
    infos.erase(std::remove_if(infos.begin(), infos.end(), [](const DeviceInfo& info) { return !info.usable(); }),
                infos.end());
    std::stable_sort(infos.begin(), infos.end(), is_stronger);
    return infos;
}

/// Of ASCII letters only, whatever the program's locale.
char lower_case(char letter) {
    return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

bool contains(std::string_view text, std::string_view part) {
    return std::search(text.begin(), text.end(), part.begin(), part.end(),
                       [](char one, char other) { return lower_case(one) == lower_case(other); }) != text.end();
}

const DeviceInfo& at_index(const std::vector<DeviceInfo>& infos, const std::string& digits) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    if (error != std::errc() || index >= infos.size())
        throw not_selected(fmt::format("there is no device {}", digits), infos);
    return infos[index];
}

const DeviceInfo& with_name(const std::vector<DeviceInfo>& infos, const std::string& part) {
    std::vector<const DeviceInfo*> usable;
    std::vector<const DeviceInfo*> unusable;
    for (const DeviceInfo& info : infos)
        if (contains(info.name, part) || contains(info.platform, part))
            (info.usable() ? usable : unusable).push_back(&info);
    if (usable.size() > 1)
        throw not_selected(fmt::format("\"{}\" fits {} devices; choose by index", part, usable.size()), infos);
    if (!usable.empty()) return *usable.front();
    if (!unusable.empty()) return *unusable.front();
    throw not_selected(fmt::format("\"{}\" is no part of the name of any device or platform", part), infos);
}

}  // namespace

Device Device::best() {
    const std::vector<DeviceInfo> infos = all();
    if (infos.empty()) throw no_device_found();
    std::string failures;
    for (const DeviceInfo& info : infos)
        if (!info.usable()) failures += fmt::format("; \"{}\" cannot be used: {}", info.name, info.why_not);
    for (const DeviceInfo& info : candidates(infos)) {
        try {
            return open(info);
        } catch (const cl::Error& error) {
            failures += fmt::format("; \"{}\" failed at {}: {}", info.name, device::call_name(error),
                                    device::code_name(error.err()));
        }
    }
    throw Error(ErrorCode::no_device,
                fmt::format("no usable OpenCL device with double precision and a compiler was found{}; {}", failures,
                            how_to_install));
}

Device Device::select(const std::string& index_or_substring) {
    const std::vector<DeviceInfo> infos = all();
    if (infos.empty()) throw no_device_found();
    if (index_or_substring.empty()) throw not_selected("no device was named", infos);
    const bool is_number = index_or_substring.find_first_not_of("0123456789") == std::string::npos;
    const DeviceInfo& info = is_number ? at_index(infos, index_or_substring) : with_name(infos, index_or_substring);
    if (!info.usable())
        throw not_selected(fmt::format("the device \"{}\" cannot be used: {}", info.name, info.why_not), infos);
    return device::guarded([&] { return open(info); });
}

Device Device::preferred() {
    const std::string choice = environment_choice();
    if (choice.empty()) return best();
    try {
        return select(choice);
    } catch (const Error& error) {
        throw Error(error.code(), fmt::format("CLSDF_DEVICE={}: {}", choice, error.what()));
    }
}

std::string Device::environment_choice() {
    const char* const choice = std::getenv("CLSDF_DEVICE");
    return choice == nullptr ? "" : choice;
}

}  // namespace clsdf

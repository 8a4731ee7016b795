#include <clsdf/calls.hpp>
#include <clsdf/device.hpp>

#include "core/floating_point.hpp"
#include "core/lifetime.hpp"
#include "core/refuse.hpp"
#include "device/context.hpp"
#include "device/find/bundled_driver.hpp"
#include "device/find/found_devices.hpp"
#include "device/find/requirements.hpp"
#include "device/find/unregistered_drivers.hpp"
#include "device/opencl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <compare>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf {

namespace fs = std::filesystem;

namespace detail {

const std::shared_ptr<DeviceContext>& DeviceContext::of(const Device& device) {
    held_by(device.context_, "Device");
    return device.context_;
}

Device DeviceContext::open(const DeviceInfo& info) {
    const DefaultFloatingPoint as_usual;
    const cl::Device device(info.id, true);
    const cl::Context context(device);
    return Device(std::make_shared<DeviceContext>(context, device, cl::CommandQueue(context, device)));
}

}  // namespace detail

device::Context& device::context_of(const Device& device) {
    return *detail::DeviceContext::of(device);
}

std::shared_ptr<device::Context> device::shared_context_of(const Device& device) {
    return detail::DeviceContext::of(device);
}

Device Device::from_handles(cl_context context, cl_device_id id, cl_command_queue queue) {
    if (context == nullptr || id == nullptr || queue == nullptr)
        refuse("a device of OpenCL's handles needs a context, a device and a queue; one of them is null");
    const DefaultFloatingPoint as_usual;
    return device::guarded([&] {
        const cl::CommandQueue callers(queue, true);
        if (callers.getInfo<CL_QUEUE_CONTEXT>()() != context || callers.getInfo<CL_QUEUE_DEVICE>()() != id)
            refuse(
                "the queue belongs to another context or device than those given; give a queue that was made for both");
        return Device(
            std::make_shared<detail::DeviceContext>(cl::Context(context, true), cl::Device(id, true), callers));
    });
}

namespace {

/// So many compute units of a device. Throws cl::Error.
cl::Device part_of(const cl::Device& whole, unsigned compute_units) {
    const auto all = whole.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
    if (compute_units == 0 || compute_units > all)
        refuse("{} compute units were asked for, and \"{}\" has 1 to {}", compute_units,
               whole.getInfo<CL_DEVICE_NAME>(), all);
    if (compute_units == all) return whole;
    const std::array<cl_device_partition_property, 4> properties{
        CL_DEVICE_PARTITION_BY_COUNTS, static_cast<cl_device_partition_property>(compute_units),
        CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    std::vector<cl::Device> parts;
    try {
        cl::Device(whole).createSubDevices(properties.data(), &parts);
    } catch (const cl::Error& error) {
        refuse_unsupported(
            "the device \"{}\" cannot be divided ({}); use all of its {} compute units, or limit "
            "them by the driver's own means (PoCL: POCL_CPU_MAX_CU_COUNT in the environment)",
            whole.getInfo<CL_DEVICE_NAME>(), device::code_name(error.err()), all);
    }
    // Never given back. PoCL ends a part with its last reference, also while one of its own threads still has a command
    // of the part, or has just ended one.
    clRetainDevice(parts.at(0)());
    return parts.at(0);
}

}  // namespace

Device Device::limited(const DeviceLimits& limits) const {
    const cl_device_id whole = id();
    if (limits.memory == std::size_t{0}) refuse("a limit of 0 bytes of device memory leaves none; leave it out");
    const DefaultFloatingPoint as_usual;
    return device::guarded([&] {
        const cl::Device part =
            limits.compute_units ? part_of(cl::Device(whole, true), *limits.compute_units) : cl::Device(whole, true);
        const cl::Context context(part);
        auto state = std::make_shared<detail::DeviceContext>(context, part, cl::CommandQueue(context, part));
        state->take_settings(device::context_of(*this));
        if (limits.memory) state->limit_memory(*limits.memory);
        return Device(std::move(state));
    });
}

DeviceInfo Device::info() const {
    const DefaultFloatingPoint as_usual;
    return device::guarded([&] {
        const device::Context& context = device::context_of(*this);
        DeviceInfo info = device::info_of(context.device());
        info.memory = context.capabilities().memory;
        info.largest_allocation = context.capabilities().largest_allocation;
        return info;
    });
}

std::string Device::name() const {
    return device::guarded([&] { return device::context_of(*this).device().getInfo<CL_DEVICE_NAME>(); });
}

std::string Device::platform() const {
    return device::guarded([&] { return device::platform_name(device::context_of(*this).device()); });
}

void Device::keep_records(const std::string& folder) const {
    device::context_of(*this).keep_records(folder);
}

std::string Device::default_record_folder() {
    if (const char* folder = std::getenv("CLSDF_CACHE_DIR")) return folder;
    // A relative path is to be ignored (XDG Base Directory Specification).
    if (const char* base = std::getenv("XDG_CACHE_HOME"); base != nullptr && fs::path(base).is_absolute())
        return fs::path(base) / "clsdf";
    if (const char* home = std::getenv("HOME"); home != nullptr && fs::path(home).is_absolute())
        return fs::path(home) / ".cache" / "clsdf";
    return {};
}

std::string Device::record_folder() const {
    return device::context_of(*this).records().folder().string();
}

void Device::read_programs(const std::string& folder) const {
    device::context_of(*this).read_programs(folder);
}

void Device::write_programs(const std::string& folder) const {
    device::context_of(*this).write_programs(folder);
}

std::size_t Device::release_memory() const {
    return device::guarded([&] { return device::context_of(*this).release_memory(); });
}

void Device::forget_records() const {
    device::Context& context = device::context_of(*this);
    context.records().forget(context.identity());
    context.forget_records();
}

cl_context Device::context() const {
    return device::context_of(*this).context()();
}
cl_device_id Device::id() const {
    return device::context_of(*this).device()();
}
cl_command_queue Device::queue() const {
    return device::context_of(*this).callers_queue()();
}

namespace {

Error no_device_found() {
    return {ErrorCode::no_device,
            fmt::format("no OpenCL device was found{}; {}", device::empty_platforms(), device::how_to_install)};
}

Error not_selected(const std::string& reason, const std::vector<DeviceInfo>& infos) {
    std::string list;
    for (const DeviceInfo& info : infos)
        list += fmt::format("{}{}: \"{}\" ({})", list.empty() ? "" : ", ", info.index, info.name, info.platform);
    return {ErrorCode::no_device, fmt::format("{}; the devices are {}", reason, list)};
}

/// A stand-in for speed: a larger one is stronger.
struct Strength {
    int kind;     ///< GPUs with memory of their own, other GPUs, processors, other devices
    double rate;  ///< units times lanes times clock

    auto operator<=>(const Strength&) const = default;
};

/// Throws cl::Error.
Strength strength_of(const DeviceInfo& info) {
    // A compute unit of Intel's GPUs is an execution unit with eight lanes, of others a multiprocessor.
    constexpr unsigned lanes_of_intel = 8, lanes_of_others = 64;
    const cl::Device device(info.id, true);
    const double units = 1.0 * info.compute_units * std::max(info.clock_megahertz, 1U);  // some report no clock
    switch (info.kind) {
        case DeviceKind::gpu: {
            const bool has_own_memory = device.getInfo<CL_DEVICE_HOST_UNIFIED_MEMORY>() == CL_FALSE;
            return {has_own_memory ? 3 : 2, units * (device::is_of_intel(device) ? lanes_of_intel : lanes_of_others)};
        }
        case DeviceKind::processor:
            return {1, units};
        default:
            return {0, units};
    }
}

/// Devices that may be taken, the strongest first. Throws cl::Error.
std::vector<DeviceInfo> candidates(std::vector<DeviceInfo> infos) {
    std::erase_if(infos, [](const DeviceInfo& info) { return !info.may_be_taken(); });
    std::ranges::stable_sort(infos, std::greater<>(), strength_of);
    return infos;
}

/// Changes ASCII letters only, in every locale.
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
    // A name that an installed PoCL has, too, means that one.
    if (usable.size() > 1)
        std::erase_if(usable, [](const DeviceInfo* info) { return info->source == DeviceSource::bundled; });
    if (usable.size() > 1)
        throw not_selected(fmt::format("\"{}\" fits {} devices; choose by index", part, usable.size()), infos);
    if (!usable.empty()) return *usable.front();
    if (!unusable.empty()) return *unusable.front();
    throw not_selected(fmt::format("\"{}\" is no part of the name of any device or platform", part), infos);
}

}  // namespace

Device Device::strongest() {
    const DefaultFloatingPoint as_usual;
    std::size_t count = 0;
    std::string failures;
    bool lacks_features = false, fails = false;
    // The bundled driver is opened if no other device is usable.
    for (const auto find : {&device::find_installed_devices, &device::find_bundled_devices}) {
        std::vector<DeviceInfo> infos;
        for (const device::FoundDevice& found : device::guarded(find)) {
            const DeviceInfo& info = infos.emplace_back(found.info);
            if (!info.usable()) failures += fmt::format("; \"{}\" cannot be used: {}", info.name, info.why_not);
            if (!info.only_if_named.empty())
                failures += fmt::format("; \"{}\" is used only if it is named: {}", info.name, info.only_if_named);
            lacks_features |= found.obstacle == device::Obstacle::missing_feature || !info.only_if_named.empty();
            fails |= found.obstacle == device::Obstacle::failing_call;
        }
        count += infos.size();
        for (const DeviceInfo& info : device::guarded([&] { return candidates(infos); })) {
            try {
                return detail::DeviceContext::open(info);
            } catch (const cl::Error& error) {
                failures += fmt::format("; \"{}\" failed at {}: {}", info.name, device::call_name(error),
                                        device::code_name(error.err()));
                fails = true;
            }
        }
    }
    if (count == 0) throw no_device_found();
    // A device with a known fault has its own remedy.
    std::string remedies;
    if (fails) remedies += "; try again, and update the driver if it fails again";
    if (lacks_features) remedies += fmt::format("; {}", device::how_to_install);
    throw Error(ErrorCode::no_device,
                fmt::format("no usable OpenCL device with double precision and a compiler was found{}{}{}", failures,
                            device::empty_platforms(), remedies));
}

Device Device::select(const std::string& index_or_substring) {
    const std::vector<DeviceInfo> infos = all();
    if (infos.empty()) throw no_device_found();
    if (index_or_substring.empty()) throw not_selected("no device was named", infos);
    const bool is_number = index_or_substring.find_first_not_of("0123456789") == std::string::npos;
    const DeviceInfo& info = is_number ? at_index(infos, index_or_substring) : with_name(infos, index_or_substring);
    if (!info.usable())
        throw not_selected(fmt::format("the device \"{}\" cannot be used: {}", info.name, info.why_not), infos);
    return device::guarded([&] { return detail::DeviceContext::open(info); });
}

namespace {

/// Empty if the variable is not set.
std::string users_choice() {
    const char* const choice = std::getenv("CLSDF_DEVICE");
    return choice == nullptr ? "" : choice;
}

}  // namespace

Device Device::automatic() {
    const std::string choice = users_choice();
    if (choice.empty()) return strongest();
    try {
        return select(choice);
    } catch (const Error& error) {
        throw Error(error.code(), fmt::format("CLSDF_DEVICE={}: {}", choice, error.what()), error.opencl_code());
    }
}

Device Device::of_rank(std::size_t rank, std::size_t ranks) {
    if (rank >= ranks) refuse("rank is {} of {} ranks; ranks count from 0 to one less than there are", rank, ranks);
    if (users_choice().empty()) {
        std::vector<DeviceInfo> gpus = all();
        std::erase_if(gpus,
                      [](const DeviceInfo& info) { return !info.may_be_taken() || info.kind != DeviceKind::gpu; });
        if (!gpus.empty()) return select(gpus[rank % gpus.size()].index);
    }
    Device device = automatic();
    const DeviceInfo info = device.info();
    if (ranks == 1 || info.kind != DeviceKind::processor) return device;
    const auto share = static_cast<unsigned>(std::max<std::size_t>(1, info.compute_units / ranks));
    return device.limited({.compute_units = share});
}

const char* name_of(DeviceKind kind) noexcept {
    switch (kind) {
        case DeviceKind::gpu:
            return "gpu";
        case DeviceKind::processor:
            return "processor";
        case DeviceKind::accelerator:
            return "accelerator";
        case DeviceKind::other:
            break;
    }
    return "other";
}

const char* name_of(DeviceSource source) noexcept {
    switch (source) {
        case DeviceSource::registered:
            return "registered";
        case DeviceSource::bundled:
            return "bundled";
        case DeviceSource::unregistered:
            return "unregistered";
        case DeviceSource::device_file:
            break;
    }
    return "device_file";
}

std::vector<DeviceInfo> Device::all() {
    const DefaultFloatingPoint as_usual;
    std::vector<DeviceInfo> infos;
    for (device::FoundDevice& found : device::guarded(device::find_devices)) infos.push_back(std::move(found.info));
    return infos;
}

std::vector<DeviceInfo> Device::unused_gpus() {
    const DefaultFloatingPoint as_usual;
    std::vector<DeviceInfo> infos;
    if (device::unregistered_drivers().empty()) return infos;
    for (device::FoundDevice& found : device::guarded(device::find_installed_devices))
        if (found.info.source == DeviceSource::device_file) infos.push_back(std::move(found.info));
    return infos;
}

}  // namespace clsdf

#include "command.hpp"
#include "device_option.hpp"
#include "option_values.hpp"
#include "output.hpp"
#include "prepare.hpp"
#include "standard_streams.hpp"

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

using clsdf::DeviceInfo;
using clsdf::DeviceKind;
using nlohmann::ordered_json;

namespace {

struct Devices {
    std::vector<DeviceInfo> all;
    const DeviceInfo* taken = nullptr;
    std::optional<clsdf::Error> failure;  ///< why none is taken

    // The device is opened, not guessed: one that cannot be opened is passed over.
    Devices() : all(clsdf::Device::all()) {
        try {
            const clsdf::Device device = clsdf::Device::preferred();
            for (const DeviceInfo& info : all)
                if (info.id == device.id()) taken = &info;
        } catch (const clsdf::Error& error) {
            failure = error;
        }
    }
    Devices(const Devices&) = delete;
    Devices& operator=(const Devices&) = delete;
};

std::string reason_of_choice(const Devices& devices) {
    const std::string choice = clsdf::Device::environment_choice();
    if (!choice.empty()) return fmt::format("CLSDF_DEVICE={} asks for it", choice);
    if (std::count_if(devices.all.begin(), devices.all.end(), [](const DeviceInfo& info) { return info.usable(); }) ==
        1)
        return "no other one is usable";
    return devices.taken->kind == DeviceKind::gpu ? "it is the strongest GPU that works, by compute units times clock"
                                                  : "no GPU works here, and it is the strongest of the others";
}

ordered_json describe(const DeviceInfo& info) {
    return {{"index", info.index},
            {"name", info.name},
            {"platform", info.platform},
            {"version", info.version},
            {"driver", info.driver},
            {"kind", name_of(info.kind)},
            {"compute_units", info.compute_units},
            {"clock_megahertz", info.clock_megahertz},
            {"memory_bytes", info.memory},
            {"largest_allocation_bytes", info.largest_allocation},
            {"fp64", info.fp64},
            {"atomics64", info.atomics64},
            {"float_width", info.float_width},
            {"usable", info.usable()},
            {"why_not", info.usable() ? ordered_json() : ordered_json(info.why_not)}};
}

ordered_json describe(const Devices& devices) {
    ordered_json all = ordered_json::array();
    for (const DeviceInfo& info : devices.all) all.push_back(describe(info));
    ordered_json taken;
    if (devices.taken != nullptr) taken = {{"index", devices.taken->index}, {"reason", reason_of_choice(devices)}};
    return {{"devices", all}, {"taken", taken}};
}

void print_human(const DeviceInfo& info) {
    const auto yes_or_no = [](bool yes) { return yes ? "yes" : "no"; };
    print_text("{}  {}\n", info.index, info.name);
    print_text("   platform  {}; {}, driver {}\n", info.platform, info.version, info.driver);
    print_text("   kind      {}: {} compute units at {} MHz, {} wide in float\n", name_of(info.kind),
               info.compute_units, info.clock_megahertz, info.float_width);
    print_text("   memory    {}, the largest allocation {}\n", human_bytes(static_cast<double>(info.memory)),
               human_bytes(static_cast<double>(info.largest_allocation)));
    print_text("   fp64      {}; 64-bit atomics {}\n", yes_or_no(info.fp64), yes_or_no(info.atomics64));
    print_text("   usable    {}\n", info.usable() ? "yes" : "no: " + info.why_not);
}

struct DevicesOptions {
    std::string device;
    bool prepare = false;
    bool again = false;
};

/// The devices to prepare: the named one, else all usable ones.
std::vector<DeviceInfo> chosen(const std::string& name) {
    std::vector<DeviceInfo> infos = clsdf::Device::all();
    std::optional<clsdf::Device> named;
    // Without a usable device this says what to install.
    if (!name.empty() || std::none_of(infos.begin(), infos.end(), [](const DeviceInfo& info) { return info.usable(); }))
        named = open_device(name);
    infos.erase(std::remove_if(infos.begin(), infos.end(),
                               [&](const DeviceInfo& info) { return named ? info.id != named->id() : !info.usable(); }),
                infos.end());
    return infos;
}

ExitStatus run(const DevicesOptions& options, Report& report) {
    if (options.prepare) {
        prepare(report, chosen(options.device), options.again);
        return ExitStatus::done;
    }
    const Devices devices;
    if (!report.quiet) {
        for (const DeviceInfo& info : devices.all) print_human(info);
        if (devices.taken != nullptr)
            print_text("Taken is device {}: {}.\n", devices.taken->index, reason_of_choice(devices));
    }
    report.result = describe(devices);
    if (devices.failure) throw clsdf::Error(*devices.failure);
    return ExitStatus::done;
}

}  // namespace

Command add_devices(CLI::App& program) {
    const auto options = std::make_shared<DevicesOptions>();
    CLI::App* parser = program.add_subcommand("devices", "List the devices of this machine, and the one that is taken");
    CLI::Option* prepare = parser->add_flag("--prepare", options->prepare,
                                            "instead: compile and test the kernels of usual calls, on all devices");
    parser
        ->add_flag("--again", options->again,
                   "with --prepare: also programs that were tested before, or ended their process")
        ->needs(prepare);
    parser->add_option("--device", options->device, "with --prepare: this one alone [all]")
        ->check(not_empty())
        ->type_name("INDEX|NAME")
        ->needs(prepare);
    parser->footer(
        "\"clsdf compute\" takes the device that --device names, else the one that the environment variable\n"
        "CLSDF_DEVICE names, else the strongest GPU, else the strongest other device. A name is an index of\n"
        "this list, or a part of the name of one device or of its platform.\n\n"
        "Kernels are compiled at their first use, which takes some seconds, and kept. --prepare compiles them now,\n"
        "for the kernels of \"clsdf compute\", with and without --json and --with triangle, and of \"clsdf "
        "render\".\n\n"
        "Examples:\n"
        "  clsdf devices\n"
        "  clsdf devices --json\n"
        "  clsdf devices --prepare\n"
        "  CLSDF_DEVICE=portable clsdf devices\n"
        "  clsdf compute bunny.off -o bunny.nrrd --device 0");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

#include "devices.hpp"

#include "command.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"
#include "second_compiler.hpp"

#include "core/stopwatch.hpp"
#include "core/tuning_variables.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/picture.hpp>
#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

using clsdf::DeviceInfo;
using clsdf::DeviceKind;
using clsdf::Stopwatch;

void add_device_option(Parser& parser, std::string& choice, const std::string& does) {
    parser.add("--device", choice, does + ", see \"clsdf devices\" [CLSDF_DEVICE, else the strongest]")
        .takes_text("INDEX|NAME");
}

namespace {

clsdf::Device chosen_device(const std::string& choice) {
    if (choice.empty()) return clsdf::Device::automatic();
    try {
        return clsdf::Device::select(choice);
    } catch (const clsdf::Error& error) {
        throw clsdf::Error(error.code(), fmt::format("--device {}: {}", choice, error.what()));
    }
}

}  // namespace

clsdf::Device open_device(const std::string& choice) {
    clsdf::Device device = chosen_device(choice);
    const std::string folder = clsdf::Device::default_record_folder();
    device.keep_records(folder);
    device.read_programs(folder);
    return device;
}

clsdf::Device open_device(const std::string& choice, Report& report) {
    clsdf::Device device = open_device(choice);
    static std::atomic<bool> is_told = false;
    if (!choice.empty() || !device_variable().empty() || is_told.exchange(true)) return device;
    for (const DeviceInfo& info : clsdf::Device::unused_gpus())
        report.warn(fmt::format(
            "{} is not used, taken is \"{}\"; \"clsdf devices\" says why; --device or CLSDF_DEVICE names a device "
            "without this warning; {}: {}",
            info.name, device.name(), info.driver_file, info.why_not));
    return device;
}

bool specialises_at_launch(const clsdf::Device& device) {
    return device.platform() == "Portable Computing Language" && device.info().kind == DeviceKind::processor;
}

std::string device_variable() {
    const char* const choice = std::getenv("CLSDF_DEVICE");
    return choice == nullptr ? "" : choice;
}

namespace {

/// The kernels that a call of "clsdf compute" needs.
struct Call {
    const char* name;
    bool triangle;
};

constexpr std::array<Call, 2> calls{Call{"compute", false}, Call{"compute --with triangle", true}};

/// The time of one call.
struct Step {
    std::string name;
    double seconds = 0;
    bool is_tested = false;  ///< tested now; false if it was tested before or has no test
};

class Preparation {
public:
    Preparation(const RunningCall& running, const clsdf::Device& device)
        : running_(running), device_(device), mesh_(clsdf::make_shape("cube")) {}

    Step compile(const Call& call) {
        clsdf::CallOptions watched = running_.call;
        running_.bar.restart();
        watched.progress = [&](const clsdf::Progress& step) {
            running_.bar.show(fmt::format("{}: {}", call.name, text_of(step)));
        };
        const Stopwatch watch;
        const clsdf::DistanceTransform transform(device_, mesh_, {}, watched);
        const clsdf::OutputSet outputs = call.triangle ? clsdf::Output::triangle : clsdf::OutputSet();
        const clsdf::Grid grid = clsdf::Grid::around(mesh_, 64, clsdf::Band::symmetric(0.1));
        Step step{call.name};
        for (const clsdf::Band& band : {clsdf::Band::symmetric(0.1), clsdf::Band::full()})
            step.is_tested |= transform.compile(grid, band, outputs, watched).first_use;
        step.seconds = watch.seconds();
        return step;
    }

    /// Traces a small picture, of a plane, because some drivers compile a kernel at its first launch.
    Step render() {
        const Stopwatch watch;
        const clsdf::Band band = clsdf::Band::full();
        clsdf::Field field({clsdf::Grid::around(mesh_, 8, band), band, clsdf::SignRule::nonzero, {}});
        const std::span<float> distance = field.distance();
        for (std::size_t n = 0; n < distance.size(); ++n) distance[n] = n < distance.size() / 2 ? -1.0F : 1.0F;
        clsdf::picture::SurfaceOptions options;
        options.width = options.height = 16;
        options.should_stop = running_.call.should_stop;
        clsdf::picture::SurfacePictures(field, device_).hits(options);
        return {"render", watch.seconds()};
    }

    /// More than a few points are looked up one by one, many in groups, on processors by another program, too.
    Step query() {
        clsdf::CallOptions watched = running_.call;
        running_.bar.restart();
        watched.progress = [&](const clsdf::Progress& step) {
            if (step.stage != clsdf::Progress::Stage::computing)
                running_.bar.show(fmt::format("query: {}", text_of(step)));
        };
        const Stopwatch watch;
        const clsdf::DistanceTransform transform(device_, mesh_, {}, watched);
        Step step{"query"};
        const std::vector<clsdf::Vec3> points(std::size_t{1} << 14U, clsdf::Vec3{0.25, 0.5, 0.75});
        std::vector<float> distance(points.size());
        step.is_tested = transform.query(points, std::numeric_limits<double>::infinity(), distance, watched).first_use;
        step.seconds = watch.seconds();
        return step;
    }

private:
    const RunningCall& running_;
    clsdf::Device device_;
    clsdf::Mesh mesh_;
};

/// A device that writes the programs that it compiles.
clsdf::Device open_to_write(const std::string& choice) {
    clsdf::Device device = open_device(choice);
    device.write_programs(clsdf::Device::default_record_folder());
    return device;
}

Json prepare(Report& report, const clsdf::DeviceInfo& info, bool again, const RunningCall& running) {
    Json steps = Json::array();
    const auto add = [&](const Step& step) {
        running.bar.clear();
        report.print("   {:<30}  {:6.2f} s{}\n", step.name, step.seconds, step.is_tested ? ", tested" : "");
        steps.push_back({{"name", step.name}, {"seconds", step.seconds}, {"tested", step.is_tested}});
    };
    report.print("{}  {} ({})\n", info.index, info.name, info.platform);
    const std::string index = std::to_string(info.index);
    const clsdf::Device launching = open_device(index), writing = open_to_write(index);
    std::optional<SecondCompiler> second_compiler;
    if (again) {
        writing.forget_records();
        for (const clsdf::Device& device : {launching, writing}) device.read_programs("");
    } else {
        second_compiler.emplace(index, std::vector<std::string>{"--prepare"});
    }
    Preparation launches(running, launching), preparation(running, writing);
    const Stopwatch watch;
    if (specialises_at_launch(writing)) {
        // So that the binaries have what launches need.
        for (const Call& call : calls) launches.compile(call);
        if (again) {
            launches.query();
            launches.render();
        }
    }
    Step first = preparation.compile(calls[0]);
    first.seconds = watch.seconds();
    add(first);
    if (second_compiler) second_compiler->wait(running.stop);
    add(preparation.compile(calls[1]));
    add(preparation.query());
    try {
        add(preparation.render());
    } catch (const clsdf::Error& error) {
        // A command without cairo draws nothing, and the bundled driver has no program for it.
        if (error.code() != clsdf::ErrorCode::unsupported) throw;
    }
    return {{"index", info.index}, {"name", info.name}, {"steps", steps}};
}

}  // namespace

void prepare_ahead(Report& report, const clsdf::Device& launching) {
    const CallErrors errors{.cancelled = "the computation was cancelled", .work_writes = true};
    run_call(report, errors, [&](const RunningCall& running) {
        const clsdf::Device writing = open_to_write(std::to_string(launching.info().index));
        Preparation launches(running, launching), preparation(running, writing);
        clsdf::tuning::compile_bricks(launching, clsdf::Output::triangle);
        launches.query();
        launches.render();
        // Queries first: the other process needs one of their programs, too, but later.
        preparation.query();
        clsdf::tuning::compile_bricks(writing, clsdf::Output::triangle);
        preparation.render();
    });
}

void prepare(Report& report, const std::vector<clsdf::DeviceInfo>& devices, bool again) {
    std::optional<clsdf::Error> failure;
    report.result["prepared"] = Json::array();
    const CallErrors errors{.cancelled = "cancelled; programs that are compiled are kept", .work_writes = true};
    run_call(report, errors, [&](const RunningCall& running) {
        for (const clsdf::DeviceInfo& info : devices) {
            try {
                report.result["prepared"].push_back(prepare(report, info, again, running));
            } catch (const clsdf::Error& error) {
                if (running.stop.stop_requested()) throw;
                running.bar.clear();
                if (failure) report.warn(failure->what());
                failure = error;
            }
        }
    });
    if (failure) throw clsdf::Error(*failure);
}

namespace {

struct Devices {
    std::vector<DeviceInfo> all;
    const DeviceInfo* taken = nullptr;
    std::optional<clsdf::Error> failure;  ///< why none is taken

    // The device is opened, not guessed: one that cannot be opened is passed over.
    Devices() : all(clsdf::Device::all()) {
        try {
            const clsdf::Device device = open_device("");
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
    const std::string choice = device_variable();
    if (!choice.empty()) return fmt::format("CLSDF_DEVICE={} asks for it", choice);
    if (std::ranges::count_if(devices.all, &DeviceInfo::usable) == 1) return "no other one is usable";
    if (std::ranges::count_if(devices.all, &DeviceInfo::may_be_taken) == 1)
        return "no other one is used unless it is named";
    return devices.taken->kind == DeviceKind::gpu
               ? "it is the strongest GPU that works: memory of its own first, then lanes times clock"
               : "no GPU works here, and it is the strongest of the others";
}

/// Whether the driver told the properties of the device, beside names and versions.
bool is_known(const DeviceInfo& info) {
    return info.compute_units > 0;
}

Json describe(const DeviceInfo& info) {
    const auto known = [&](const auto& value) { return is_known(info) ? Json(value) : Json(); };
    const auto not_empty = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
    return {{"index", info.index},
            {"name", info.name},
            {"platform", not_empty(info.platform)},
            {"version", not_empty(info.version)},
            {"driver", not_empty(info.driver)},
            {"kind", known(name_of(info.kind))},
            {"compute_units", known(info.compute_units)},
            {"clock_megahertz", known(info.clock_megahertz)},
            {"memory_bytes", known(info.memory)},
            {"largest_allocation_bytes", known(info.largest_allocation)},
            {"fp64", known(info.fp64)},
            {"atomics64", known(info.atomics64)},
            {"float_width", known(info.float_width)},
            {"source", name_of(info.source)},
            {"driver_file", not_empty(info.driver_file)},
            {"usable", info.usable()},
            {"why_not", not_empty(info.why_not)},
            {"only_if_named", not_empty(info.only_if_named)}};
}

Json describe(const Devices& devices) {
    Json all = Json::array();
    for (const DeviceInfo& info : devices.all) all.push_back(describe(info));
    Json taken;
    if (devices.taken != nullptr) taken = {{"index", devices.taken->index}, {"reason", reason_of_choice(devices)}};
    return {{"devices", all}, {"taken", taken}};
}

std::string how_found(const DeviceInfo& info) {
    switch (info.source) {
        case clsdf::DeviceSource::registered:
            break;
        case clsdf::DeviceSource::bundled:
            return "in clsdf's package: " + info.driver_file;
        case clsdf::DeviceSource::unregistered:
            return "in a driver that OpenCL's loader does not know: " + info.driver_file;
        case clsdf::DeviceSource::device_file:
            return "by its file: " + info.driver_file;
    }
    return "by OpenCL's loader";
}

std::string text_of_use(const DeviceInfo& info) {
    if (!info.usable()) return "no: " + info.why_not;
    return info.may_be_taken() ? "yes" : "only if it is named: " + info.only_if_named;
}

void print_human(const DeviceInfo& info) {
    const auto yes_or_no = [](bool yes) { return yes ? "yes" : "no"; };
    print_text("{}  {}\n", info.index, info.name);
    if (!info.platform.empty())
        print_text("   platform  {}{}{}\n", info.platform, info.version.empty() ? "" : "; " + info.version,
                   info.driver.empty() ? "" : ", driver " + info.driver);
    if (is_known(info)) {
        print_text("   kind      {}: {} compute units at {} MHz, {} wide in float\n", name_of(info.kind),
                   info.compute_units, info.clock_megahertz, info.float_width);
        print_text("   memory    {}, the largest allocation {}\n", human_bytes(static_cast<double>(info.memory)),
                   human_bytes(static_cast<double>(info.largest_allocation)));
        print_text("   fp64      {}; 64-bit atomics {}\n", yes_or_no(info.fp64), yes_or_no(info.atomics64));
    }
    print_text("   found     {}\n", how_found(info));
    print_text("   usable    {}\n", text_of_use(info));
}

struct DevicesOptions {
    std::string device;
    bool prepare = false;
    bool again = false;
};

/// The devices to prepare: the named one, else all that may be taken.
std::vector<DeviceInfo> chosen(const std::string& name) {
    std::vector<DeviceInfo> infos = clsdf::Device::all();
    std::optional<clsdf::Device> named;
    // Without a device this says what to install.
    if (!name.empty() || std::ranges::none_of(infos, &DeviceInfo::may_be_taken)) named = open_device(name);
    std::erase_if(infos, [&](const DeviceInfo& info) { return named ? info.id != named->id() : !info.may_be_taken(); });
    return infos;
}

/// A GPU that Windows shows to WSL2: its file tells neither the maker nor whether there is a driver of OpenCL.
void tell_of_wsl(const std::vector<DeviceInfo>& devices) {
    const bool has_gpu = std::ranges::any_of(
        devices, [](const DeviceInfo& info) { return info.kind == DeviceKind::gpu && info.usable(); });
    const char* const named = clsdf::tuning_variable("CLSDF_DEVICE_FILES");
    const std::filesystem::path gpu = std::filesystem::path(named != nullptr ? named : "/dev") / "dxg";
    std::error_code error;
    if (!has_gpu && std::filesystem::exists(gpu, error))
        print_text(
            "This is WSL2, by {}: a GPU of Intel computes if its driver is installed (Debian: intel-opencl-icd) and "
            "the GPU has double precision; NVIDIA and AMD have no OpenCL driver for WSL2, and processors compute.\n",
            gpu.string());
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
        tell_of_wsl(devices.all);
    }
    report.result = describe(devices);
    if (devices.failure) throw clsdf::Error(*devices.failure);
    return ExitStatus::done;
}

}  // namespace

Command add_devices(Parser& program) {
    const auto options = std::make_shared<DevicesOptions>();
    Parser parser = program.add_subcommand("devices", "List the devices of this machine, and the one that is taken");
    parser.add("--prepare", options->prepare, "instead: compile and test the kernels of usual calls, on all devices");
    parser.add("--again", options->again, "with --prepare: also programs that were prepared before").needs("--prepare");
    parser.add("--device", options->device, "with --prepare: this one alone [all]")
        .takes_text("INDEX|NAME")
        .needs("--prepare");
    parser.set_footer(
        "\"clsdf compute\" takes the device that --device names, else the one that the environment variable\n"
        "CLSDF_DEVICE names, else the strongest GPU, else the strongest other device. A name is an index of\n"
        "this list, or a part of the name of one device or of its platform.\n\n"
        "Kernels are compiled at their first use, which takes some seconds, and drivers keep them. --prepare compiles\n"
        "and tests them now, and writes them to the folder of CLSDF_CACHE_DIR: those of \"clsdf compute\", with and\n"
        "without --with triangle, of \"clsdf query\" and of \"clsdf render\".\n\n"
        "Examples:\n"
        "  clsdf devices\n"
        "  clsdf devices --json\n"
        "  clsdf devices --prepare\n"
        "  CLSDF_DEVICE=portable clsdf devices\n"
        "  clsdf compute bunny.off -o bunny.nrrd --device 0");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

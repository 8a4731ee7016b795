#include "compute.hpp"
#include "command.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "progress_bar.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Stopwatch;

Error too_large(const clsdf::Grid& grid) {
    return {ErrorCode::out_of_memory, fmt::format("a field of {} x {} x {} samples does not fit the memory",
                                                  grid.size[0], grid.size[1], grid.size[2])};
}

Error with_remedy(const Error& error) {
    if (error.code() != ErrorCode::out_of_memory) return error;
    return {error.code(), fmt::format("{}; choose a lower --resolution or a larger --spacing", error.what())};
}

clsdf::FieldDescription describe_field(const ComputeLayout& layout) {
    clsdf::FieldDescription field;
    field.grid = layout.grid;
    field.band = layout.band;
    field.sign = layout.sign;
    // The field carries the name of the mesh file without its folder, which is private.
    field.mesh_name = std::filesystem::path(layout.mesh_file).filename().string();
    return field;
}

// The library's message speaks to programs, which can compute parts of a grid.
void check_size(const clsdf::Grid& grid) {
    try {
        grid.sample_count();
    } catch (const Error&) {
        throw too_large(grid);
    }
}

/// The named device, or nothing if none is named. It is opened before the mesh is read, so that an error costs no time.
std::optional<clsdf::Device> named_device(const ComputeOptions& options) {
    if (options.device.empty() && clsdf::Device::environment_choice().empty()) return std::nullopt;
    return open_device(options.device);
}

Computation compute(const ComputeRequest& request, const ComputeLayout& layout,
                    const std::optional<clsdf::Device>& named, clsdf::FieldWriter& writer, Report& report,
                    const std::stop_token& stop) {
    Computation result;
    ProgressBar progress(!report.quiet);

    const Stopwatch setup;
    const clsdf::Device device = named ? *named : clsdf::Device::preferred();
    clsdf::TransformOptions transform_options;
    transform_options.sign = request.sign;
    transform_options.method = clsdf::papers_method({.polyhedra = request.polyhedra, .scan = request.scan});
    transform_options.log = [&](const std::string& message) {
        if (message == layout.sign_warning) return;  // has been said
        progress.clear();
        report.warn(message);
    };
    clsdf::CallOptions call;
    call.count = report.json;
    call.should_stop = [&stop] { return stop.stop_requested(); };
    call.progress = [&](double fraction) { progress.show(fraction); };
    call.compiling = [&](const clsdf::Compilation& step) { progress.show(text_of(step)); };
    const clsdf::DistanceTransform transform(device, layout.mesh, transform_options, call);
    transform.compile(layout.grid, layout.band, layout.outputs, call);
    result.device_name = device.name();
    result.device_platform = device.platform();
    result.keeps_records = !device.record_folder().empty();
    const double setup_seconds = setup.seconds();
    progress.restart();

    // Slab by slab: the next one is computed while one is written, so the memory does not limit the field.
    const Stopwatch compute;
    call.statistics = &result.statistics;
    const clsdf::FieldDescription field = describe_field(layout);
    transform.compute_slabs(
        layout.grid, layout.band, layout.outputs,
        [&](const clsdf::Grid&, const clsdf::FieldSlab& slab) {
            result.compute_seconds = compute.seconds();
            const Stopwatch write;
            result.band_samples += count_band_samples(field, slab);
            writer.append(slab);
            result.write_seconds += write.seconds();
        },
        {}, call);
    result.setup_seconds = std::max(0.0, setup_seconds - result.statistics.compile_seconds);
    result.field_seconds = compute.seconds();
    return result;
}

// The device ends in order. Its compiler may react to the same signals and fail; the reason is still the user's wish.
Computation compute_unless_interrupted(const ComputeRequest& request, const ComputeLayout& layout,
                                       const std::optional<clsdf::Device>& named, clsdf::FieldWriter& writer,
                                       Report& report) {
    const Interruption interruption;
    try {
        Computation computation = compute(request, layout, named, writer, report, interruption.token());
        if (!interruption.token().stop_requested()) return computation;
    } catch (const Error&) {
        if (!interruption.token().stop_requested()) throw;
    }
    throw Error(ErrorCode::cancelled, "cancelled; nothing was written");
}

void warn(Report& report, const std::string& warning) {
    if (!warning.empty()) report.warn(warning);
}

ExitStatus run(const ComputeOptions& options, Report& report) {
    const ComputeRequest request(options);
    if (!options.output.empty())
        clsdf::check_output(options.output, request.outputs);
    else if (!options.dry_run)
        throw Error(ErrorCode::invalid_argument,
                    "state the output: -o FILE, with the ending .nrrd, .npy, .vti, .h5, .vdb or .sdf");
    const std::optional<clsdf::Device> device = named_device(options);

    const Stopwatch read;
    const clsdf::Mesh mesh = clsdf::read_mesh(options.mesh);
    const double read_seconds = read.seconds();

    const clsdf::Grid grid = request.grid_around(mesh.box());
    const clsdf::Band band = request.band_on(grid, mesh.box());
    check_size(grid);
    const clsdf::Topology topology = describe_topology(mesh);
    const clsdf::ResolvedSignRule sign = resolve_sign_rule(request.sign, topology);
    const ComputeLayout layout{mesh,         options.mesh,    topology,          grid,        band, sign.rule,
                               sign.warning, request.outputs, request.polyhedra, request.scan};
    warn(report, sign.warning);
    warn(report, warning_of_polyhedra(layout));
    warn(report, warning_of_format(layout, options.output));
    if (!report.quiet) print_layout(layout);
    if (options.dry_run) {
        if (!report.quiet) print_memory(layout);
        if (device) report.print("device  {} ({})\n", device->name(), device->platform());
        warn(report, warning_of_memory(layout));
        report.result = describe_dry_run(layout);
        return ExitStatus::done;
    }

    // Opening and finishing may wait for the reader of a pipe or for a disk, so Ctrl-C ends the program at once there.
    clsdf::FieldWriter writer(options.output, describe_field(layout), layout.outputs);
    Computation computation = compute_unless_interrupted(request, layout, device, writer, report);
    const Stopwatch finish;
    writer.finish();
    output_is_written();
    computation.write_seconds += finish.seconds();
    computation.field_seconds += finish.seconds();
    computation.read_seconds = read_seconds;
    computation.output = options.output;
    if (!report.quiet) print_outcome(layout, computation);
    warn(report, warning_of_empty_band(layout, computation));
    warn(report, warning_of_stale_outputs(layout, computation));
    report.result = describe(layout, computation);
    return ExitStatus::done;
}

}  // namespace

Command add_compute(CLI::App& program) {
    const auto options = std::make_shared<ComputeOptions>();
    CLI::App* parser = program.add_subcommand("compute", "Compute the distance field of a mesh");
    add_options(*parser, *options);
    return {parser, [options](Report& report) {
                try {
                    return run(*options, report);
                } catch (const Error& error) {
                    throw with_remedy(error);
                }
            }};
}

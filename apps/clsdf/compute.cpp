#include "command.hpp"
#include "compute_options.hpp"
#include "compute_report.hpp"
#include "interruption.hpp"
#include "output.hpp"
#include "progress_bar.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Stopwatch;

Error cancellation() {
    return {ErrorCode::cancelled, "cancelled; nothing was written"};
}

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
    // Where the file lay concerns nobody else who gets the field.
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

Computation compute_and_write(const ComputeOptions& options, const ComputeRequest& request, const ComputeLayout& layout,
                              const std::stop_token& stop) {
    Computation result;
    ProgressBar progress(!options.quiet);

    const Stopwatch setup;
    const clsdf::Device device =
        options.device.empty() ? clsdf::Device::preferred() : clsdf::Device::select(options.device);
    clsdf::TransformOptions transform_options;
    transform_options.sign = request.sign;
    transform_options.polyhedra = request.polyhedra;
    transform_options.scan = request.scan;
    transform_options.count = options.json;
    transform_options.stop = stop;
    transform_options.progress = [&](double fraction) { progress.show(fraction); };
    clsdf::DistanceTransform transform(device, layout.mesh, transform_options);
    result.device_name = device.name();
    result.device_platform = device.platform();
    result.setup_seconds = setup.seconds();

    // Slab by slab, the next one being computed while one is written: no field is too large for the memory.
    const Stopwatch compute;
    const clsdf::FieldDescription field = describe_field(layout);
    clsdf::FieldWriter writer(options.output, field, layout.outputs);
    transform.compute_slabs(layout.grid, layout.band, layout.outputs,
                            [&](const clsdf::Grid&, const clsdf::FieldSlab& slab) {
                                result.compute_seconds = compute.seconds();
                                const Stopwatch write;
                                result.band_samples += count_band_samples(field, slab);
                                writer.append(slab);
                                result.write_seconds += write.seconds();
                            });
    result.statistics = transform.statistics();
    progress.clear();

    if (stop.stop_requested()) throw cancellation();
    const Stopwatch finish;
    writer.finish();
    result.write_seconds += finish.seconds();
    result.field_seconds = compute.seconds();
    result.output = options.output;
    return result;
}

void warn(ComputeLayout& layout, const std::string& warning) {
    if (warning.empty()) return;
    layout.warnings.push_back(warning);
    fmt::print(stderr, "warning: {}\n", warning);
}

// The compilers of some devices listen to the same signals and fail then; the user's wish is the reason all the same.
Computation run_on_device(const ComputeOptions& options, const ComputeRequest& request, const ComputeLayout& layout) {
    const Interruption interruption;
    try {
        return compute_and_write(options, request, layout, interruption.token());
    } catch (const Error&) {
        if (interruption.token().stop_requested()) throw cancellation();
        throw;
    }
}

ExitStatus run(const ComputeOptions& options) {
    const ComputeRequest request(options);
    if (!options.output.empty())
        clsdf::Field::check_output(options.output, request.outputs);
    else if (!options.dry_run)
        throw Error(ErrorCode::invalid_argument,
                    "state where the field goes: -o FILE, with the ending .nrrd, .npy, .vti, .h5, .vdb or .sdf");

    const Stopwatch read;
    const clsdf::Mesh mesh = clsdf::read_mesh(options.mesh);
    const double read_seconds = read.seconds();

    const clsdf::Grid grid = request.grid_around(mesh.box());
    const clsdf::Band band = request.band_on(grid, mesh.box());
    check_size(grid);
    const clsdf::Topology topology = describe_topology(mesh);
    const clsdf::ResolvedSignRule sign = resolve_sign_rule(request.sign, topology);
    ComputeLayout layout{mesh,      options.mesh,    topology,          grid,         band,
                         sign.rule, request.outputs, request.polyhedra, request.scan, {}};
    warn(layout, sign.warning);
    warn(layout, warning_of_polyhedra(layout));
    if (!options.quiet) print_layout(layout);
    if (options.dry_run) {
        if (!options.quiet) print_memory(layout);
        warn(layout, warning_of_memory(layout));
        if (options.json) print_result(describe_dry_run(layout));
        return ExitStatus::done;
    }

    Computation computation = run_on_device(options, request, layout);
    computation.read_seconds = read_seconds;
    if (!options.quiet) print_outcome(layout, computation);
    warn(layout, warning_of_empty_band(layout, computation));
    warn(layout, warning_of_stale_triangles(layout, computation));
    if (options.json) print_result(describe(layout, computation));
    return ExitStatus::done;
}

}  // namespace

Command add_compute(CLI::App& program) {
    const auto options = std::make_shared<ComputeOptions>();
    CLI::App* parser = program.add_subcommand("compute", "Compute the distance field of a mesh");
    add_options(*parser, *options);
    return {parser, [options] {
                try {
                    return run(*options);
                } catch (const Error& error) {
                    throw with_remedy(error);
                }
            }};
}

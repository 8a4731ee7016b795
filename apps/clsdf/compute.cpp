#include "command.hpp"
#include "compute_options.hpp"
#include "compute_report.hpp"
#include "interruption.hpp"
#include "output.hpp"
#include "progress_bar.hpp"

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <chrono>
#include <memory>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;

class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

Error cancellation() {
    return {ErrorCode::cancelled, "cancelled; nothing was written"};
}

Computation compute_and_write(const ComputeOptions& options, const ComputeRequest& request, const ComputeLayout& layout,
                              const std::stop_token& stop) {
    Computation result;
    ProgressBar progress(!options.quiet);

    const Stopwatch setup;
    const clsdf::Device device = clsdf::Device::best();
    clsdf::TransformOptions transform_options;
    transform_options.sign = request.sign;
    transform_options.count = options.json;
    transform_options.stop = stop;
    transform_options.progress = [&](double fraction) { progress.show(fraction); };
    clsdf::DistanceTransform transform(device, layout.mesh, transform_options);
    result.device_name = device.name();
    result.device_platform = device.platform();
    result.setup_seconds = setup.seconds();

    const Stopwatch compute;
    const clsdf::Field field = transform(layout.grid, layout.band, request.outputs);
    result.compute_seconds = compute.seconds();
    result.statistics = transform.statistics();
    result.band_samples = count_band_samples(field);
    progress.clear();

    if (stop.stop_requested()) throw cancellation();
    const Stopwatch write;
    field.write(options.output);
    result.write_seconds = write.seconds();
    result.output = options.output;
    return result;
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
        clsdf::Field::check_output(options.output);
    else if (!options.dry_run)
        throw Error(ErrorCode::invalid_argument, "state where the field goes: -o FILE.nrrd or -o FILE.npy");

    const Stopwatch read;
    const clsdf::Mesh mesh = clsdf::read_mesh(options.mesh);
    const double read_seconds = read.seconds();

    const clsdf::Grid grid = request.grid_around(mesh.box());
    const clsdf::Band band = request.band_on(grid, mesh.box());
    grid.sample_count();
    const clsdf::ResolvedSignRule sign = resolve_sign_rule(request.sign, describe_topology(mesh));
    ComputeLayout layout{mesh, options.mesh, grid, band, sign.rule, request.outputs, {}};
    if (!sign.warning.empty()) {
        layout.warnings.push_back(sign.warning);
        fmt::print(stderr, "warning: {}\n", sign.warning);
    }
    if (!options.quiet) print_layout(layout);
    if (options.dry_run) {
        if (!options.quiet) print_memory(layout);
        if (options.json) print_result(describe_dry_run(layout));
        return ExitStatus::done;
    }

    Computation computation = run_on_device(options, request, layout);
    computation.read_seconds = read_seconds;
    if (!options.quiet) print_outcome(layout, computation);
    if (options.json) print_result(describe(layout, computation));
    return ExitStatus::done;
}

}  // namespace

Command add_compute(CLI::App& program) {
    const auto options = std::make_shared<ComputeOptions>();
    CLI::App* parser = program.add_subcommand("compute", "Compute the distance field of a mesh");
    add_options(*parser, *options);
    return {parser, [options] { return run(*options); }};
}

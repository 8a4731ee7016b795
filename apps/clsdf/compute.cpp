#include "compute.hpp"

#include "command.hpp"
#include "core/outputs.hpp"
#include "core/stopwatch.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"
#include "second_compiler.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <variant>

using clsdf::Band;
using clsdf::Error;
using clsdf::ErrorCode;

namespace {

using clsdf::Stopwatch;

Error too_large(const clsdf::Grid& grid) {
    return {ErrorCode::out_of_memory, fmt::format("a field of {} x {} x {} samples does not fit the memory",
                                                  grid.size[0], grid.size[1], grid.size[2])};
}

clsdf::FieldDescription describe_field(const ComputeLayout& layout) {
    clsdf::FieldDescription field;
    field.grid = layout.grid;
    field.band = layout.band;
    field.sign = layout.sign;
    field.floor = layout.floor;
    field.positive_inside = layout.positive_inside;
    // The field carries the name of the mesh file without its folder, which is private.
    field.mesh_name = names_of(layout.mesh_files);
    field.groups = layout.groups;
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
    if (options.device.empty() && device_variable().empty()) return std::nullopt;
    return open_device(options.device);
}

/// The file of the field: written from bricks if the format and the field allow it, else from slices.
using Writer = std::variant<clsdf::FieldWriter, clsdf::SparseFieldWriter>;

Writer make_writer(const ComputeLayout& layout, const std::string& path) {
    if (layout.is_sparse) return clsdf::SparseFieldWriter(path, describe_field(layout), layout.outputs);
    return clsdf::FieldWriter(path, describe_field(layout), layout.outputs);
}

/// Throws Error(unsupported) if --sparse is given for a format that stores no sparse fields.
void check_sparse_format(const ComputeOptions& options) {
    if (options.sparse && !options.output.empty() && !clsdf::stores_sparse_fields(options.output))
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: this format stores no sparse fields; choose .npy, .h5, .vdb or .nvdb, or leave "
                                "--sparse out",
                                options.output));
}

/// Throws Error(unsupported) if --with asks for groups and the format does not store them.
void check_group_format(const ComputeOptions& options) {
    const bool is_wanted = std::ranges::find(options.with, group_word) != options.with.end();
    if (is_wanted && !options.output.empty() && !clsdf::stores_groups(options.output))
        throw Error(ErrorCode::unsupported,
                    fmt::format("--with group: {}: this format stores no groups; choose .vti or .vtkhdf, or --with "
                                "triangle and the groups of \"clsdf info\"",
                                options.output));
}

/// Whether the field is computed and written as bricks. Throws Error(invalid_argument) if --sparse asks for it in vain.
bool is_sparse(const ComputeOptions& options, const Band& band, clsdf::SignRule sign, clsdf::Scan scan) {
    const double widest = sign == clsdf::SignRule::none ? band.outside : band.widest();
    const char* const reason = scan != clsdf::Scan::bricks ? "--scan and --polyhedra ask for a published method; leave "
                                                             "them out"
                               : !std::isfinite(widest)    ? "the band has no end; give --band a width, as 3v"
                               : band.has_signs_only       ? "--band 0 asks for the signs alone; give the band a width"
                                                           : nullptr;
    if (reason == nullptr)
        return options.sparse || (!options.output.empty() && clsdf::stores_sparse_fields_only(options.output));
    if (options.sparse)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--sparse: {}, or compute a dense field without --sparse", reason));
    return false;
}

Computation compute(const ComputeRequest& request, const ComputeLayout& layout,
                    const std::optional<clsdf::Device>& named, std::optional<SecondCompiler>& second_compiler,
                    Writer& writer, Report& report, const RunningCall& running) {
    Computation result;
    const Stopwatch setup;
    const clsdf::Device device = named ? *named : open_device({}, report);
    clsdf::TransformOptions transform_options;
    transform_options.sign = request.sign;
    transform_options.floor = request.floor;
    transform_options.surface = request.surface;
    clsdf::CallOptions call = running.call;
    // The published methods are compared by their work. Kernels that count it are compiled beside the usual ones.
    call.count_work = report.json && request.scan != clsdf::Scan::bricks;
    call.progress = [&, watch = call.progress](const clsdf::Progress& step) {
        watch(step);
        if (step.stage == clsdf::Progress::Stage::testing && second_compiler) second_compiler->wait(running.stop);
    };
    call.log = [&, log = call.log](const std::string& message) {
        const bool has_been_said = layout.surface == clsdf::Surface::given && message == layout.sign_warning;
        if (!has_been_said) log(message);
    };
    const clsdf::DistanceTransform transform = make_transform(
        device, layout.mesh, {.polyhedra = request.polyhedra, .scan = request.scan}, transform_options, call);
    const clsdf::TransformStatistics compiled = transform.compile(layout.grid, layout.band, layout.outputs, call);
    second_compiler.reset();
    result.device_name = device.name();
    result.device_platform = device.platform();
    const std::string folder = device.record_folder();
    result.keeps_records = !folder.empty() && ::access(folder.c_str(), W_OK | X_OK) == 0;
    const double setup_seconds = setup.seconds();
    running.bar.restart();

    // Slab by slab: the next one is computed while one is written, so the memory does not limit the field.
    const Stopwatch compute;
    const clsdf::FieldDescription field = describe_field(layout);
    std::vector<float> distance, gradient;
    const auto negated = [&](clsdf::FieldSlab slab) {
        const auto negate = [](std::span<const float> values, std::vector<float>& room) {
            room.assign(values.begin(), values.end());
            clsdf::negate(room);
            return std::span<const float>(room);
        };
        slab.set(clsdf::Output::distance, negate(slab.distance(), distance));
        slab.set(clsdf::Output::gradient, negate(slab.gradient(), gradient));
        return slab;
    };
    const auto store = [&](const auto& slab, const auto& append) {
        result.compute_seconds = compute.seconds();
        const Stopwatch write;
        result.band_samples += count_band_samples(field, slab);
        append();
        result.write_seconds += write.seconds();
    };
    if (auto* const bricks = std::get_if<clsdf::SparseFieldWriter>(&writer))
        result.statistics = transform.compute_sparse(
            layout.grid, layout.band, layout.outputs,
            [&](const clsdf::SparseSlab& slab) {
                store(slab, [&] {
                    clsdf::SparseSlab written = slab;
                    if (field.positive_inside) written.values = negated(slab.values);
                    bricks->append(written);
                });
            },
            call);
    else
        result.statistics = transform.compute(
            layout.grid, layout.band, layout.outputs,
            [&](const clsdf::Grid&, const clsdf::FieldSlab& slab) {
                store(slab, [&] {
                    std::get<clsdf::FieldWriter>(writer).append(field.positive_inside ? negated(slab) : slab);
                });
            },
            {.sink_has_own_thread = true}, call);
    result.statistics.compile_seconds += compiled.compile_seconds;
    result.statistics.first_use |= compiled.first_use;
    result.setup_seconds = std::max(0.0, setup_seconds - result.statistics.compile_seconds);
    result.field_seconds = compute.seconds();
    return result;
}

ExitStatus run(const ComputeOptions& options, Report& report) {
    if (std::ranges::any_of(options.mesh, is_scene_file)) return compute_scene(options, report);
    const ComputeRequest request(options);
    keep_mesh(options.mesh, options.output);
    check_sparse_format(options);
    check_group_format(options);
    if (!options.output.empty())
        clsdf::check_field_path(options.output, request.outputs);
    else if (!options.dry_run)
        throw Error(ErrorCode::invalid_argument,
                    "state the output: -o FILE, with the ending .nrrd, .npy, .vti, .vtkhdf, .h5, .vdb, .nvdb or .sdf");
    const std::optional<clsdf::Device> device = named_device(options);
    std::optional<SecondCompiler> second_compiler;
    if (!options.dry_run && request.scan == clsdf::Scan::bricks) {
        take_turn_to_compile(report);
        if (is_first_use()) second_compiler.emplace(options.device, bricks_ahead(request.outputs));
    }

    const Stopwatch read;
    const clsdf::Mesh mesh = read_body(options.mesh, options.reading, report);
    const double read_seconds = read.seconds();

    const clsdf::Grid grid = request.grid_around(mesh.box());
    const clsdf::Band band = request.band_on(grid, mesh.box());
    check_size(grid);
    const clsdf::Topology topology = describe_topology(mesh);
    const clsdf::ResolvedSignRule sign = resolve_sign_rule(request.sign, topology);
    const ComputeLayout layout{
        mesh,
        options.mesh,
        topology,
        grid,
        band,
        sign.rule,
        request.floor,
        request.surface,
        sign.warning,
        request.outputs,
        options.positive_inside,
        request.polyhedra,
        request.scan,
        is_sparse(options, band, sign.rule, request.scan),
        wants_groups(options.with, mesh) ? std::make_shared<const clsdf::FaceGroups>(mesh.groups()) : nullptr};
    const auto need_sign = [&](const char* what, const char* instead) {
        require_sign(sign.rule, topology, options.mesh, options.sign, what, instead);
    };
    if (band.has_signs_only) need_sign("--band 0, the signs alone, needs", "give the band a width");
    if (options.positive_inside) need_sign("--positive-inside needs", "leave that out");
    if (options.exact_signs) need_sign("--exact-signs needs", "leave that out");
    if (options.positive_inside && band.has_signs_only)
        throw Error(ErrorCode::invalid_argument,
                    "--positive-inside: with --band 0 the field has the signs of zeros alone, and these are negative "
                    "inside; leave it out, or give the band a width");
    // The transform says more about the outer surface.
    if (request.surface == clsdf::Surface::given) report.warn(sign.warning);
    if (sign.rule == clsdf::SignRule::none && !options.band_inside.empty())
        report.warn("--band-inside has no effect, because the field has no sign");
    report.warn(warning_of_size(layout.grid, layout.mesh.box()));
    report.warn(warning_between_samples(layout.grid, layout.mesh.box(), layout.sign));
    report.warn(warning_of_narrow_band(layout.grid, layout.band, layout.sign));
    report.warn(warning_of_polyhedra(layout));
    report.warn(warning_of_format(layout, options.output));
    if (!report.quiet) print_layout(layout);
    if (options.dry_run) {
        // The format may refuse the field. A pipe or a device is left alone.
        std::error_code ignored;
        if (!options.output.empty() && !std::filesystem::is_other(options.output, ignored))
            make_writer(layout, options.output);
        if (!report.quiet) print_memory(layout);
        if (device) report.print("device  {} ({})\n", device->name(), device->platform());
        report.warn(warning_of_memory(layout));
        report.result = describe_dry_run(layout);
        return ExitStatus::done;
    }

    // Opening and finishing may wait for the reader of a pipe or for a disk, so Ctrl-C ends the program at once there.
    Writer writer = make_writer(layout, options.output);
    Computation computation;
    run_call(report, {}, [&](const RunningCall& running) {
        computation = compute(request, layout, device, second_compiler, writer, report, running);
    });
    const Stopwatch finish;
    std::visit([](auto& of_field) { of_field.finish(); }, writer);
    output_is_written();
    computation.write_seconds += finish.seconds();
    computation.field_seconds += finish.seconds();
    computation.read_seconds = read_seconds;
    computation.output = options.output;
    if (!report.quiet) print_outcome(layout, computation);
    report.warn(warning_of_empty_band(describe_field(layout), layout.mesh.box(), computation.band_samples));
    report.warn(warning_of_stale_outputs(layout, computation));
    report.result = describe(layout, computation);
    return ExitStatus::done;
}

}  // namespace

Error with_remedy(const ComputeOptions& options, const Error& error) {
    if (error.code() != ErrorCode::out_of_memory) return error;
    const char* const remedy = !options.samples.empty()   ? "fewer --samples"
                               : !options.cells.empty()   ? "fewer --cells"
                               : !options.size.empty()    ? "a smaller --size"
                               : !options.spacing.empty() ? "a larger --spacing"
                                                          : "a lower --resolution";
    return {error.code(), fmt::format("{}; choose {}", error.what(), remedy)};
}

Command add_compute(Parser& program) {
    const auto options = std::make_shared<ComputeOptions>();
    Parser parser = program.add_subcommand("compute", "Compute the distance field of a mesh");
    add_options(parser, *options);
    return {parser, [options](Report& report) {
                try {
                    return run(*options, report);
                } catch (const Error& error) {
                    throw with_remedy(*options, error);
                }
            }};
}

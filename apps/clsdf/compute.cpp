#include "compute.hpp"

#include "command.hpp"
#include "core/outputs.hpp"
#include "core/real_numbers.hpp"
#include "core/stopwatch.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "second_compiler.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

using clsdf::Band;
using clsdf::Box;
using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Grid;
using clsdf::Index3;
using clsdf::Length;
using clsdf::Vec3;

namespace {

Vec3 parse_spacing(const std::string& text) {
    const Vec3 spacing = parse_triple<double>("--spacing", text, "one number or three, as 0.01 or 1,1,0.5", true);
    constexpr auto least = static_cast<double>(std::numeric_limits<float>::min());
    constexpr auto most = static_cast<double>(std::numeric_limits<float>::max());
    for (const double step : spacing)
        if (std::isfinite(step) && step > 0 && (step < least || step > most))
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("--spacing: {} is beyond the floats that distances are given in; choose a {} spacing", step,
                            step < least ? "larger" : "smaller"));
    return spacing;
}

Grid parse_stated_grid(const ComputeOptions& options) {
    if (options.size.empty() || options.origin.empty() || options.spacing.empty())
        throw Error(
            ErrorCode::invalid_argument,
            "a grid stated in full needs --size, --origin and --spacing; without --size and --origin it is laid "
            "around the mesh");
    Grid grid;
    grid.size = parse_triple<std::int64_t>("--size", options.size, "three whole numbers, as 256,256,128", true);
    grid.origin = parse_triple<double>("--origin", options.origin, "three numbers, as -1,-1,0", false);
    grid.spacing = parse_spacing(options.spacing);
    if (options.cell_centred) grid = grid.cell_centred();
    grid.validate();
    return grid;
}

clsdf::AxisCounts parse_counts(const std::string& option, const std::string& text) {
    if (text.empty()) return {};
    return parse_triple<std::int64_t>(option, text, "one whole number or three, as 64 or 64,64,32", true);
}

Grid parse_box(const ComputeOptions& options) {
    const auto corners = parse_list<double>(options.box);
    if (!corners || corners->size() != 6)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--box: expected two corners, as -1,-1,-1,1,1,1, not '{}'", options.box));
    const std::vector<double>& at = *corners;
    if (options.samples.empty() == options.cells.empty())
        throw Error(ErrorCode::invalid_argument,
                    "--box is divided by --samples or by --cells; give one of them, as --cells 64");
    if (options.cell_centred && options.cells.empty())
        throw Error(ErrorCode::invalid_argument, "--box with --cell-centred needs --cells, not --samples");
    return Grid::between(
        {at[0], at[1], at[2]}, {at[3], at[4], at[5]},
        {parse_counts("--samples", options.samples), parse_counts("--cells", options.cells), options.cell_centred});
}

void add_grid_options(Parser& parser, ComputeOptions& options) {
    parser.begin_group("Grid");
    parser.add("--resolution", options.resolution, "samples on the longest side, margin included")
        .takes_whole_number("N", 2, most_samples_on_a_side);
    parser.add("--spacing", options.spacing, "instead: distance of the samples, for all axes or each")
        .takes_text("H[,H,H]")
        .excludes("--resolution");
    parser.add("--margin", options.margin, "room around the mesh [the band's width outside, 5% without an end]")
        .takes_text("LENGTH");
    parser.add("--cubic", options.cubic, "as many samples on every axis");
    parser.add("--size", options.size, "with --origin and --spacing: a grid stated in full")
        .takes_text("NX,NY,NZ")
        .excludes("--resolution")
        .excludes("--margin")
        .excludes("--cubic");
    parser.add("--origin", options.origin, "its first sample").takes_text("X,Y,Z");
    parser.add("--box", options.box, "with --samples or --cells: a grid from corner to corner, the first one exactly")
        .takes_text("X0,Y0,Z0,X1,Y1,Z1")
        .excludes("--resolution")
        .excludes("--spacing")
        .excludes("--margin")
        .excludes("--cubic")
        .excludes("--size")
        .excludes("--origin");
    parser.add("--samples", options.samples, "of the box, both ends included, for all axes or each")
        .takes_text("N[,N,N]")
        .needs("--box");
    parser.add("--cells", options.cells, "of the box; one sample more, or with --cell-centred as many")
        .takes_text("N[,N,N]")
        .needs("--box")
        .excludes("--samples");
    parser.add("--cell-centred", options.cell_centred, "samples at the centres of cells: all half a voxel further");
}

void add_field_options(Parser& parser, ComputeOptions& options) {
    parser.begin_group("Field");
    parser.add("--band", options.band, "half width of the band on both sides").takes_text("LENGTH");
    parser.add("--band-inside", options.band_inside, "half width inside [--band]").takes_text("LENGTH");
    parser.add("--band-outside", options.band_outside, "half width outside [--band]").takes_text("LENGTH");
    add_sign_option(parser, options.sign);
    add_positive_inside_option(parser, options.positive_inside);
    add_weld_option(parser, options.weld);
    add_outputs_option(parser, options.with);
    parser.add("--sparse", options.sparse,
               "only the bricks of 8 x 8 x 8 samples near the surface: .npy or .h5; .vdb and .nvdb are always sparse");
}

void add_method_options(Parser& parser, ComputeOptions& options) {
    parser.begin_group("Method");
    parser
        .add("--polyhedra", options.polyhedra,
             "what bounds the samples of a triangle: leaned, which are exact; or, to compare, mauch, exact too, and "
             "peikert-sigg, which are not")
        .takes_one_of({"leaned", "peikert-sigg", "mauch"});
    parser.add("--scan", options.scan, "how their samples are found; auto: by bricks if the polyhedra allow it")
        .takes_one_of({"auto", "bricks", "slices", "brute-force"});
}

}  // namespace

void add_options(Parser& parser, ComputeOptions& options) {
    add_mesh_argument(parser, options.mesh);
    parser.add("-o,--output", options.output, "the field: .nrrd, .npy, .vti, .h5, .vdb, .nvdb or .sdf").takes("FIELD");
    add_grid_options(parser, options);
    add_field_options(parser, options);
    add_method_options(parser, options);
    parser.begin_group("Options");
    add_placement_options(parser, options.placement);
    add_device_option(parser, options.device, "what computes");
    parser.add("--dry-run", options.dry_run, "print the grid and the memory it needs, and stop");
    parser.set_footer(
        "A LENGTH is 10% (of the longest side of the mesh's box), 3v (voxels), 0.05 (the mesh's units) or\n"
        "full (without end). Samples beyond the band carry its half width, with the sign.\n\n"
        "Examples:\n"
        "  clsdf compute bunny.off -o bunny.nrrd\n"
        "  clsdf compute bunny.off -o bunny.npy --resolution 512 --band 3v --with triangle\n"
        "  clsdf compute wing.stl -o wing.nrrd --spacing 0.01 --band-inside 0 --band-outside 0.2\n"
        "  clsdf compute bunny.off -o bunny.h5 --resolution 2048 --band 3v --sparse\n"
        "  clsdf compute part.ply -o part.nrrd --size 128,128,64 --origin -1,-1,0 --spacing 0.02\n"
        "  clsdf compute part.ply -o part.nrrd --box -1,-1,0,1,1,1 --cells 128,128,64 --cell-centred\n"
        "  clsdf compute bunny.off --resolution 2048 --dry-run");
}

ComputeRequest::ComputeRequest(const ComputeOptions& options)
    : band_inside(Length::parse(options.band, "--band")),
      band_outside(band_inside),
      sign(parse_sign(options.sign)),
      outputs(parse_outputs(options.with)),
      polyhedra(value_named(options.polyhedra,
                            {clsdf::Polyhedra::leaned, clsdf::Polyhedra::peikert_sigg, clsdf::Polyhedra::mauch})),
      scan(resolve_scan(polyhedra, value_named(options.scan, {clsdf::Scan::automatic, clsdf::Scan::bricks,
                                                              clsdf::Scan::slices, clsdf::Scan::brute_force}))) {
    if (!options.band_inside.empty()) band_inside = Length::parse(options.band_inside, "--band-inside");
    if (!options.band_outside.empty()) band_outside = Length::parse(options.band_outside, "--band-outside");
    for (const clsdf::OutputInfo& info : extra_outputs())
        if (scan != clsdf::Scan::bricks && outputs.contains(info.output) && info.output != clsdf::Output::triangle)
            throw Error(ErrorCode::unsupported,
                        fmt::format("--with: the scan {} does not know the output {}; use --polyhedra leaned and "
                                    "--scan bricks, or leave the output out",
                                    name_of(scan), info.name));
    if (!options.size.empty() || !options.origin.empty() || !options.box.empty()) {
        stated_grid = options.box.empty() ? parse_stated_grid(options) : parse_box(options);
        return;
    }
    grid.resolution = options.resolution;
    grid.cubic = options.cubic;
    grid.cell_centred = options.cell_centred;
    if (!options.spacing.empty()) grid.spacing = parse_spacing(options.spacing);
    if (!options.margin.empty())
        grid.margin = Length::parse(options.margin, "--margin");
    else if (!band_outside.is_infinite())
        grid.margin = band_outside;
}

Grid ComputeRequest::grid_around(const Box& box) const {
    return stated_grid ? *stated_grid : Grid::around(box, grid);
}

Band ComputeRequest::band_on(const Grid& samples, const Box& box) const {
    const double extent = box.longest_side();
    Band band{band_inside.resolve(samples.voxel(), extent), band_outside.resolve(samples.voxel(), extent)};
    band.has_signs_only = band.inside == 0 && band.outside == 0;
    for (const auto& [side, half_width] : {std::pair("inside", band.inside), std::pair("outside", band.outside)})
        if (std::isfinite(half_width) && half_width > static_cast<double>(std::numeric_limits<float>::max()))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("--band, --band-{}: a half width of {} is beyond the floats that distances are "
                                    "given in; choose a narrower band, or full",
                                    side, half_width));
    return band;
}

namespace {

using clsdf::Stopwatch;

Error too_large(const clsdf::Grid& grid) {
    return {ErrorCode::out_of_memory, fmt::format("a field of {} x {} x {} samples does not fit the memory",
                                                  grid.size[0], grid.size[1], grid.size[2])};
}

Error with_remedy(const ComputeOptions& options, const Error& error) {
    if (error.code() != ErrorCode::out_of_memory) return error;
    const char* const remedy = !options.samples.empty()   ? "fewer --samples"
                               : !options.cells.empty()   ? "fewer --cells"
                               : !options.size.empty()    ? "a smaller --size"
                               : !options.spacing.empty() ? "a larger --spacing"
                                                          : "a lower --resolution";
    return {error.code(), fmt::format("{}; choose {}", error.what(), remedy)};
}

clsdf::FieldDescription describe_field(const ComputeLayout& layout) {
    clsdf::FieldDescription field;
    field.grid = layout.grid;
    field.band = layout.band;
    field.sign = layout.sign;
    field.positive_inside = layout.positive_inside;
    // The field carries the name of the mesh file without its folder, which is private.
    field.mesh_name = names_of(layout.mesh_files);
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
                    Writer& writer, Report& report, const std::stop_token& stop) {
    Computation result;
    ProgressBar progress(!report.quiet);

    const Stopwatch setup;
    const clsdf::Device device = named ? *named : open_device({}, report);
    clsdf::TransformOptions transform_options;
    transform_options.sign = request.sign;
    clsdf::CallOptions call;
    // The published methods are compared by their work. Kernels that count it are compiled beside the usual ones.
    call.count_work = report.json && request.scan != clsdf::Scan::bricks;
    call.should_stop = [&stop] { return stop.stop_requested(); };
    call.progress = [&](const clsdf::Progress& step) {
        show(progress, step);
        if (step.stage == clsdf::Progress::Stage::testing && second_compiler) second_compiler->wait(stop);
    };
    call.log = [&](const std::string& message) {
        if (message == layout.sign_warning) return;  // has been said
        progress.clear();
        report.warn(message);
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
    progress.restart();

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

// The device ends in order. Its compiler may react to the same signals and fail; the reason is still the user's wish.
Computation compute_unless_interrupted(const ComputeRequest& request, const ComputeLayout& layout,
                                       const std::optional<clsdf::Device>& named,
                                       std::optional<SecondCompiler>& second_compiler, Writer& writer, Report& report) {
    const Interruption interruption;
    try {
        Computation computation =
            compute(request, layout, named, second_compiler, writer, report, interruption.token());
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
    keep_mesh(options.mesh, options.output);
    check_sparse_format(options);
    if (!options.output.empty())
        clsdf::check_field_path(options.output, request.outputs);
    else if (!options.dry_run)
        throw Error(ErrorCode::invalid_argument,
                    "state the output: -o FILE, with the ending .nrrd, .npy, .vti, .h5, .vdb, .nvdb or .sdf");
    const std::optional<clsdf::Device> device = named_device(options);
    std::optional<SecondCompiler> second_compiler;
    if (!options.dry_run && request.scan == clsdf::Scan::bricks && is_first_use())
        second_compiler.emplace(options.device, bricks_ahead(request.outputs));

    const Stopwatch read;
    const clsdf::Mesh mesh = welded(read_body(options.mesh, report, options.placement), options.weld);
    const double read_seconds = read.seconds();

    const clsdf::Grid grid = request.grid_around(mesh.box());
    const clsdf::Band band = request.band_on(grid, mesh.box());
    check_size(grid);
    const clsdf::Topology topology = describe_topology(mesh);
    const clsdf::ResolvedSignRule sign = resolve_sign_rule(request.sign, topology);
    const ComputeLayout layout{mesh,
                               options.mesh,
                               topology,
                               grid,
                               band,
                               sign.rule,
                               sign.warning,
                               request.outputs,
                               options.positive_inside,
                               request.polyhedra,
                               request.scan,
                               is_sparse(options, band, sign.rule, request.scan)};
    if (band.has_signs_only && sign.rule == clsdf::SignRule::none)
        throw Error(ErrorCode::invalid_argument,
                    "--band 0 asks for the signs alone, and the field has no sign; give the band a width, or choose a "
                    "sign rule");
    if (options.positive_inside && (band.has_signs_only || sign.rule == clsdf::SignRule::none))
        throw Error(ErrorCode::invalid_argument,
                    band.has_signs_only
                        ? "--positive-inside: with --band 0 the field has the signs of zeros alone, and "
                          "these are negative inside; leave it out, or give the band a width"
                        : "--positive-inside: the field has no sign, so nothing is inside; leave it "
                          "out, or choose another --sign");
    warn(report, sign.warning);
    if (sign.rule == clsdf::SignRule::none && !options.band_inside.empty())
        report.warn("--band-inside has no effect, because the field has no sign");
    warn(report, warning_of_narrow_band(layout));
    warn(report, warning_of_polyhedra(layout));
    warn(report, warning_of_format(layout, options.output));
    if (!report.quiet) print_layout(layout);
    if (options.dry_run) {
        // The format may refuse the field. A pipe or a device is left alone.
        std::error_code ignored;
        if (!options.output.empty() && !std::filesystem::is_other(options.output, ignored))
            make_writer(layout, options.output);
        if (!report.quiet) print_memory(layout);
        if (device) report.print("device  {} ({})\n", device->name(), device->platform());
        warn(report, warning_of_memory(layout));
        report.result = describe_dry_run(layout);
        return ExitStatus::done;
    }

    // Opening and finishing may wait for the reader of a pipe or for a disk, so Ctrl-C ends the program at once there.
    Writer writer = make_writer(layout, options.output);
    Computation computation = compute_unless_interrupted(request, layout, device, second_compiler, writer, report);
    const Stopwatch finish;
    std::visit([](auto& of_field) { of_field.finish(); }, writer);
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

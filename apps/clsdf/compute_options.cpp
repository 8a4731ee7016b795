#include "compute.hpp"
#include "core/outputs.hpp"
#include "devices.hpp"
#include "option_values.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

using clsdf::Band;
using clsdf::Box;
using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Grid;
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

void add_field_options(Parser& parser, ComputeOptions& options) {
    parser.begin_group("Field");
    parser.add("--band", options.band, "half width of the band on both sides").takes_text("LENGTH");
    parser.add("--band-inside", options.band_inside, "half width inside [--band]").takes_text("LENGTH");
    parser.add("--band-outside", options.band_outside, "half width outside [--band]").takes_text("LENGTH");
    add_sign_options(parser, options.sign);
    add_surface_option(parser, options.sign.surface);
    add_positive_inside_option(parser, options.positive_inside);
    parser.add("--exact-signs", options.exact_signs,
               "the field is below 0 at exactly the samples inside, on the surface, too");
    add_weld_option(parser, options.reading);
    add_outputs_and_groups_option(parser, options.with);
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

void add_grid_options(Parser& parser, ComputeOptions& options, const std::string& margin) {
    parser.begin_group("Grid");
    parser.add("--resolution", options.resolution, "samples on the longest side, margin included")
        .takes_whole_number("N", 2, most_samples_on_a_side);
    parser.add("--spacing", options.spacing, "instead: distance of the samples, for all axes or each")
        .takes_text("H[,H,H]")
        .excludes("--resolution");
    parser.add("--margin", options.margin, margin).takes_text("LENGTH");
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
    parser
        .add("--samples", options.samples,
             "of the box, both ends included, for all axes or each; 1 for a slice, where both are equal")
        .takes_text("N[,N,N]")
        .needs("--box");
    parser.add("--cells", options.cells, "of the box; one sample more, or with --cell-centred as many")
        .takes_text("N[,N,N]")
        .needs("--box")
        .excludes("--samples");
    parser.add("--cell-centred", options.cell_centred, "samples at the centres of cells: all half a voxel further");
}

void add_options(Parser& parser, ComputeOptions& options) {
    add_mesh_argument(parser, options.mesh);
    parser.add("-o,--output", options.output, "the field: .nrrd, .npy, .vti, .vtkhdf, .h5, .vdb, .nvdb or .sdf")
        .takes("FIELD")
        .in_usage();  // but for --dry-run
    add_grid_options(parser, options, "room around the mesh [the band's width outside, 5% without an end]");
    add_field_options(parser, options);
    add_method_options(parser, options);
    parser.begin_group("Options");
    add_placement_options(parser, options.reading);
    add_group_option(parser, options.reading);
    add_skip_option(parser, options.reading);
    add_device_option(parser, options.device, "what computes");
    parser.add("--dry-run", options.dry_run, "print the grid and the memory it needs, and stop");
    parser.set_footer(
        "A LENGTH is 10% (of the longest side of the mesh's box), 3v (voxels), 0.05 (the mesh's units) or\n"
        "full (without end). Samples beyond the band carry its half width, with the sign.\n"
        "In place of meshes, a file .json has many bodies with poses (docs/scenes.md). The field has the least of\n"
        "their signed distances, and --with body says which one is nearest.\n\n"
        "Examples:\n"
        "  clsdf compute bunny.off -o bunny.nrrd\n"
        "  clsdf compute bunny.off -o bunny.npy --resolution 512 --band 3v --with triangle\n"
        "  clsdf compute wing.stl -o wing.nrrd --spacing 0.01 --band-inside 0 --band-outside 0.2\n"
        "  clsdf compute bunny.off -o bunny.h5 --resolution 2048 --band 3v --sparse\n"
        "  clsdf compute part.ply -o part.nrrd --size 128,128,64 --origin -1,-1,0 --spacing 0.02\n"
        "  clsdf compute part.ply -o part.nrrd --box -1,-1,0,1,1,1 --cells 128,128,64 --cell-centred\n"
        "  clsdf compute arm.json -o arm.vti --spacing 0.01 --band 5v --with body\n"
        "  clsdf compute bunny.off --resolution 2048 --dry-run");
}

ComputeRequest::ComputeRequest(const ComputeOptions& options)
    : band_inside(Length::parse(options.band, "--band")),
      band_outside(band_inside),
      exact_signs(options.exact_signs),
      sign(parse_sign(options.sign)),
      floor(options.sign.floor),
      surface(parse_surface(options.sign.surface)),
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
    if (exact_signs && scan != clsdf::Scan::bricks)
        throw Error(ErrorCode::unsupported,
                    fmt::format("--exact-signs: the scan {} does not know them; use --polyhedra leaned and --scan "
                                "bricks, or leave it out",
                                name_of(scan)));
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
    band.has_exact_signs = exact_signs;
    for (const auto& [side, half_width] : {std::pair("inside", band.inside), std::pair("outside", band.outside)})
        if (std::isfinite(half_width) && half_width > static_cast<double>(std::numeric_limits<float>::max()))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("--band, --band-{}: a half width of {} is beyond the floats that distances are "
                                    "given in; choose a narrower band, or full",
                                    side, half_width));
    return band;
}

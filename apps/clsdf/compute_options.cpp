#include "compute.hpp"

#include "devices.hpp"
#include "option_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

using clsdf::Band;
using clsdf::Box;
using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Grid;
using clsdf::Index3;
using clsdf::Length;
using clsdf::Vec3;

namespace {

// "1,2,3" -> three numbers; nothing for any other text.
template <class Number>
std::optional<std::vector<Number>> parse_list(const std::string& text) {
    std::vector<Number> numbers;
    const char* position = text.data();
    const char* const end = text.data() + text.size();
    while (true) {
        Number number{};
        const auto [stop, error] = std::from_chars(position, end, number);
        if (error != std::errc()) return std::nullopt;
        numbers.push_back(number);
        if (stop == end) return numbers;
        if (*stop != ',') return std::nullopt;
        position = stop + 1;
    }
}

template <class Number>
std::array<Number, 3> parse_triple(const std::string& option, const std::string& text, const std::string& expected,
                                   bool one_for_all) {
    const auto numbers = parse_list<Number>(text);
    if (numbers && numbers->size() == 3) return {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    if (numbers && numbers->size() == 1 && one_for_all) return {(*numbers)[0], (*numbers)[0], (*numbers)[0]};
    throw Error(ErrorCode::invalid_argument, fmt::format("{}: expected {}, not '{}'", option, expected, text));
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
    grid.spacing = parse_triple<double>("--spacing", options.spacing, "one number or three, as 0.01 or 1,1,0.5", true);
    if (options.cell_centred) grid = grid.cell_centred();
    grid.validate();
    return grid;
}

void add_grid_options(CLI::App& parser, ComputeOptions& options) {
    constexpr const char* group = "Grid";
    CLI::Option* resolution =
        parser.add_option("--resolution", options.resolution, "samples on the longest side, margin included")
            ->check(whole_number(2, most_samples_on_a_side))
            ->type_name("N")
            ->capture_default_str();
    CLI::Option* spacing =
        parser.add_option("--spacing", options.spacing, "instead: distance of the samples, for all axes or each")
            ->type_name("H[,H,H]")
            ->excludes(resolution);
    CLI::Option* margin =
        parser.add_option("--margin", options.margin, "room around the mesh [the band's width outside]")
            ->type_name("LENGTH");
    CLI::Option* cubic = parser.add_flag("--cubic", options.cubic, "as many samples on every axis");
    CLI::Option* size = parser.add_option("--size", options.size, "with --origin and --spacing: a grid stated in full")
                            ->type_name("NX,NY,NZ")
                            ->excludes(resolution)
                            ->excludes(margin)
                            ->excludes(cubic);
    CLI::Option* origin = parser.add_option("--origin", options.origin, "its first sample")->type_name("X,Y,Z");
    CLI::Option* cell_centred = parser.add_flag("--cell-centred", options.cell_centred,
                                                "samples at the centres of cells: all half a voxel further");
    for (CLI::Option* option : {spacing, margin, size, origin}) option->check(not_empty());
    for (CLI::Option* option : {resolution, spacing, margin, cubic, size, origin, cell_centred}) option->group(group);
}

void add_field_options(CLI::App& parser, ComputeOptions& options) {
    constexpr const char* group = "Field";
    parser.add_option("--band", options.band, "half width of the band on both sides")
        ->check(not_empty())
        ->type_name("LENGTH")
        ->capture_default_str()
        ->group(group);
    parser.add_option("--band-inside", options.band_inside, "half width inside [--band]")
        ->check(not_empty())
        ->type_name("LENGTH")
        ->group(group);
    parser.add_option("--band-outside", options.band_outside, "half width outside [--band]")
        ->check(not_empty())
        ->type_name("LENGTH")
        ->group(group);
    add_sign_option(parser, options.sign)->group(group);
    add_outputs_option(parser, options.with)->group(group);
}

void add_method_options(CLI::App& parser, ComputeOptions& options) {
    constexpr const char* group = "Method";
    takes_one_of(
        parser
            .add_option("--polyhedra", options.polyhedra,
                        "what bounds the samples of a triangle: leaned, which are exact; or, to compare, mauch, "
                        "exact too, and peikert-sigg, which are not")
            ->capture_default_str()
            ->group(group),
        {"leaned", "peikert-sigg", "mauch"});
    takes_one_of(parser
                     .add_option("--scan", options.scan,
                                 "how their samples are found; auto: by bricks if the polyhedra allow it")
                     ->capture_default_str()
                     ->group(group),
                 {"auto", "bricks", "slices", "brute-force"});
}

}  // namespace

void add_options(CLI::App& parser, ComputeOptions& options) {
    parser.add_option("MESH", options.mesh, "the mesh: .off, .obj, .stl or .ply")->required();
    parser.add_option("-o,--output", options.output, "the field: .nrrd, .npy, .vti, .h5, .vdb or .sdf")
        ->type_name("FIELD");
    add_grid_options(parser, options);
    add_field_options(parser, options);
    add_method_options(parser, options);
    add_device_option(parser, options.device, "what computes");
    parser.add_flag("--dry-run", options.dry_run, "print the grid and the memory it needs, and stop");
    parser.footer(
        "A LENGTH is 10% (of the longest side of the mesh's box), 3v (voxels), 0.05 (the mesh's units) or\n"
        "full (without end). Samples beyond the band carry its half width, with the sign.\n\n"
        "Examples:\n"
        "  clsdf compute bunny.off -o bunny.nrrd\n"
        "  clsdf compute bunny.off -o bunny.npy --resolution 512 --band 3v --with triangle\n"
        "  clsdf compute wing.stl -o wing.nrrd --spacing 0.01 --band-inside 0 --band-outside 0.2\n"
        "  clsdf compute part.ply -o part.nrrd --size 128,128,64 --origin -1,-1,0 --spacing 0.02\n"
        "  clsdf compute bunny.off --resolution 2048 --dry-run");
}

ComputeRequest::ComputeRequest(const ComputeOptions& options)
    : band_inside(parse_length("--band", options.band)),
      band_outside(band_inside),
      sign(parse_sign(options.sign)),
      outputs(parse_outputs(options.with)),
      polyhedra(value_named(options.polyhedra,
                            {clsdf::Polyhedra::leaned, clsdf::Polyhedra::peikert_sigg, clsdf::Polyhedra::mauch})),
      scan(resolve_scan(polyhedra, value_named(options.scan, {clsdf::Scan::automatic, clsdf::Scan::bricks,
                                                              clsdf::Scan::slices, clsdf::Scan::brute_force}))) {
    if (!options.band_inside.empty()) band_inside = parse_length("--band-inside", options.band_inside);
    if (!options.band_outside.empty()) band_outside = parse_length("--band-outside", options.band_outside);
    if (!options.size.empty() || !options.origin.empty()) {
        stated_grid = parse_stated_grid(options);
        return;
    }
    grid.resolution = options.resolution;
    grid.cubic = options.cubic;
    grid.cell_centred = options.cell_centred;
    if (!options.spacing.empty())
        grid.spacing =
            parse_triple<double>("--spacing", options.spacing, "one number or three, as 0.01 or 1,1,0.5", true);
    if (!options.margin.empty())
        grid.margin = parse_length("--margin", options.margin);
    else if (!band_outside.is_infinite())
        grid.margin = band_outside;
}

Grid ComputeRequest::grid_around(const Box& box) const {
    return stated_grid ? *stated_grid : Grid::around(box, grid);
}

Band ComputeRequest::band_on(const Grid& samples, const Box& box) const {
    const double extent = box.longest_side();
    return {band_inside.resolve(samples.voxel(), extent), band_outside.resolve(samples.voxel(), extent)};
}

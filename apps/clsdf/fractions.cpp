#include "command.hpp"
#include "compute.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "outer_surface.hpp"
#include "report.hpp"
#include "run_call.hpp"

#include "core/files.hpp"
#include "core/stopwatch.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <bit>
#include <memory>
#include <optional>
#include <string>

namespace {

struct FractionChoice {
    ComputeOptions grid;  ///< those of the grid, the sign and the mesh alone
    std::string convention = "plain";
    std::string part, walls;  ///< empty: the convention's
    double snap = 0;
};

clsdf::FractionOptions options_of(const FractionChoice& choice) {
    clsdf::FractionOptions options =
        choice.part.empty()
            ? clsdf::FractionOptions::of(choice.convention)
            : clsdf::FractionOptions::of(choice.convention,
                                         choice.part == "solid" ? clsdf::CellPart::solid : clsdf::CellPart::fluid);
    if (!choice.walls.empty())
        options.walls = choice.walls == "solid"   ? clsdf::WallCell::solid
                        : choice.walls == "fluid" ? clsdf::WallCell::fluid
                                                  : clsdf::WallCell::above;
    options.snap = choice.snap;
    return options;
}

void require_memory_of_cells(const std::string& output, const clsdf::Grid& grid) {
    const auto cells = static_cast<double>(grid.size[0] - 1) * static_cast<double>(grid.size[1] - 1) *
                       static_cast<double>(grid.size[2] - 1);
    // A bit a cell, and the widest array of the file.
    const double bytes_of_cell = 0.125 + (clsdf::ending_of(output) == ".vti" ? 24 : 1);
    require_memory(cells * bytes_of_cell, fmt::format("the fractions of {} x {} x {} cells", grid.size[0] - 1,
                                                      grid.size[1] - 1, grid.size[2] - 1));
}

ExitStatus run(const FractionChoice& choice, Report& report) {
    const ComputeOptions& own = choice.grid;
    clsdf::check_fractions_path(own.output);
    if (own.cell_centred)
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "--cell-centred: cells lie between neighbouring samples, which are at their corners; leave "
                           "it out");
    const ComputeRequest request(own);
    const clsdf::Stopwatch watch;
    std::optional<OuterOfFiles> outer;
    clsdf::Grid grid;
    clsdf::Fractions found;
    run_call(report, {.explain = [&](const clsdf::Error& error) { return with_remedy(own, error); }},
             [&](const RunningCall& running) {
                 outer = outer_of_files(own.mesh, own.reading, own.sign, own.output, running.call, report);
                 grid = request.grid_around(outer->box);
                 report.warn(warning_of_size(grid, outer->box));
                 require_memory_of_cells(own.output, grid);
                 found = clsdf::fractions(outer->surface, grid, options_of(choice), running.call);
             });
    const clsdf::OuterSurface& surface = outer->surface;
    const double seconds = watch.seconds();
    clsdf::write_fractions(found, own.output);
    output_is_written();
    std::size_t full = 0;
    for (const std::uint8_t byte : found.full) full += static_cast<std::size_t>(std::popcount(byte));
    double volume = static_cast<double>(full), area = 0;
    for (const clsdf::CellFraction& cell : found.cells) {
        volume += cell.volume;
        area += cell.area;
    }
    volume *= grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
    const auto [nx, ny, nz] = found.counts();
    const char* const part = found.options.part == clsdf::CellPart::solid ? "solid" : "fluid";
    report.print("mesh    {}: {} vertices, {} triangles\n", outer->name, outer->vertices, outer->triangles);
    report.print("outer   {} triangles; volume {:.6g}, area {:.6g}\n", surface.mesh.triangles().size(), surface.volume,
                 surface.area);
    report.print("cells   {} x {} x {}: the surface meets {}, {} are wholly {}\n", nx, ny, nz, found.cells.size(), full,
                 part);
    report.print("volume  of {} {:.6g} in the grid; done in {:.3f} s\n", part, volume, seconds);
    report.print("wrote   {}\n", own.output);
    if (found.cells.empty()) report.warn(warning_of_nothing("the surface meets no cell", grid, outer->box));
    report.result = {{"mesh", paths_of(own.mesh)},
                     {"grid", describe(grid)},
                     {"convention", choice.convention},
                     {"part", part},
                     {"cut_cells", found.cells.size()},
                     {"full_cells", full},
                     {"volume", volume},
                     {"area", found.options.areas_of_faces ? Json() : Json(area)},
                     {"outer_volume", surface.volume},
                     {"outer_area", surface.area},
                     {"seconds", seconds},
                     {"output", own.output}};
    return ExitStatus::done;
}

}  // namespace

Command add_fractions(Parser& program) {
    const auto choice = std::make_shared<FractionChoice>();
    Parser parser = program.add_subcommand("fractions", "Measure the parts of a grid's cells that a mesh fills");
    ComputeOptions& own = choice->grid;
    own.margin = "5%";
    parser.add("MESH", own.mesh, "the mesh: .off, .obj, .stl or .ply; several files are one body; or a scene, .json")
        .required();
    parser.add("-o,--output", own.output, "the fractions: .npz, .h5 or .vti").takes("RESULT").required();
    add_grid_options(parser, own, "room around the mesh");
    parser.begin_group("Options");
    parser.add("--convention", choice->convention, "what is counted, and how; amrex and chombo: the fluid")
        .takes_one_of({"plain", "amrex", "chombo", "vtk"});
    parser
        .add("--part", choice->part,
             "instead of the convention's: what is counted; solid with amrex and chombo: a flow within the mesh")
        .takes_one_of({"solid", "fluid"});
    parser.add("--walls", choice->walls, "instead of the convention's: the cell that has a wall between two cells")
        .takes_one_of({"above", "solid", "fluid"});
    parser.add("--snap", choice->snap, "move vertices onto planes between cells that are so near: 0 to 0.001")
        .takes("CELLS");
    add_sign_option_of_outer(parser, own.sign);
    add_placement_options(parser, own.reading);
    add_weld_option(parser, own.reading);
    add_skip_option(parser, own.reading);
    parser.set_footer(
        "A cell lies between neighbouring samples of the grid. The file has, for each cell that the surface meets, "
        "the\n"
        "volume, the centroid, the area and normal of the surface, and the fractions of the six faces, by the\n"
        "triangles as given: docs/fractions.md. Parts that overlap count once, as in \"clsdf outer\".\n\n"
        "Examples:\n"
        "  clsdf fractions bunny.off -o bunny.npz --resolution 65\n"
        "  clsdf fractions wing.stl -o wing.vti --box -1,-1,-1,3,1,1 --cells 128,64,64 --convention vtk\n"
        "  clsdf fractions tank.stl -o tank.h5 --spacing 0.01 --convention amrex");
    return {parser, [choice](Report& report) { return run(*choice, report); }};
}

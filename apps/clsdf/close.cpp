#include "command.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

struct CloseOptions {
    std::vector<std::string> mesh;
    MeshReading reading;
    std::string output;
    std::optional<double> floor{};
};

clsdf::Mesh closed(const CloseOptions& options, const clsdf::Mesh& mesh) {
    try {
        return close_down(mesh, *options.floor);
    } catch (const clsdf::Error& error) {
        throw clsdf::Error(error.code(),
                           fmt::format("{}: --floor {}: {}", paths_of(options.mesh), *options.floor, error.what()));
    }
}

ExitStatus run(const CloseOptions& options, Report& report) {
    keep_mesh(options.mesh, options.output);
    const clsdf::Mesh mesh = read_body(options.mesh, options.reading, report), result = closed(options, mesh);
    clsdf::write_mesh(result, options.output);
    output_is_written();
    report.print("mesh    {}: {} vertices, {} triangles\n", paths_of(options.mesh), mesh.vertices().size(),
                 mesh.triangles().size());
    report.print("closed  {} vertices, {} triangles\n", result.vertices().size(), result.triangles().size());
    report.print("wrote   {}\n", options.output);
    report.result = {{"mesh", paths_of(options.mesh)},
                     {"floor", *options.floor},
                     {"vertices", result.vertices().size()},
                     {"triangles", result.triangles().size()},
                     {"output", options.output}};
    return ExitStatus::done;
}

}  // namespace

Command add_close(Parser& program) {
    const auto options = std::make_shared<CloseOptions>();
    Parser parser = program.add_subcommand("close", "Close a terrain by walls from its rim and a floor");
    add_mesh_argument(parser, options->mesh);
    parser.add("-o,--output", options->output, "the closed mesh: .off, .obj, .stl or .ply").takes("FILE").required();
    parser.add("--floor", options->floor, "z of the floor, below the lowest vertex").takes_number("Z").required();
    add_placement_options(parser, options->reading);
    add_weld_option(parser, options->reading);
    add_skip_option(parser, options->reading);
    parser.set_footer(
        "All faces of a terrain look up, and its rim does not overlap itself, seen from above. The mesh that is\n"
        "written has the terrain's vertices and triangles first, and no groups. Its distance is that to the walls and\n"
        "the floor, too; --sign below takes them for the sign alone.\n\n"
        "Examples:\n"
        "  clsdf close terrain.stl -o solid.stl --floor -10\n"
        "  clsdf close hills.obj -o solid.off --floor 0 --up y && clsdf compute solid.off -o solid.nrrd");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

#include "command.hpp"
#include "compute.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "outer_surface.hpp"
#include "report.hpp"
#include "run_call.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/outer.hpp>

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

struct OuterOptions {
    std::vector<std::string> mesh;
    MeshReading reading;
    SignChoice sign;
    std::string output;
};

ExitStatus run(const OuterOptions& options, Report& report) {
    clsdf::check_mesh_path(options.output);
    std::optional<OuterOfFiles> found;
    run_call(report, {}, [&](const RunningCall& running) {
        found = outer_of_files(options.mesh, options.reading, options.sign, options.output, running.call, report);
    });
    const clsdf::OuterSurface& surface = found->surface;
    clsdf::write_mesh(surface, options.output);
    output_is_written();
    report.print("mesh    {}: {} vertices, {} triangles\n", found->name, found->vertices, found->triangles);
    report.print("outer   {} vertices, {} triangles; of the faces as given {} are whole, {} in part, {} hidden\n",
                 surface.mesh.vertices().size(), surface.mesh.triangles().size(), surface.whole_faces,
                 surface.partial_faces, surface.hidden_faces);
    report.print("volume  {:.6g}, area {:.6g}\n", surface.volume, surface.area);
    report.print("wrote   {}\n", options.output);
    report.result = {{"mesh", paths_of(options.mesh)},
                     {"vertices", surface.mesh.vertices().size()},
                     {"triangles", surface.mesh.triangles().size()},
                     {"whole_faces", surface.whole_faces},
                     {"partial_faces", surface.partial_faces},
                     {"hidden_faces", surface.hidden_faces},
                     {"volume", surface.volume},
                     {"area", surface.area},
                     {"output", options.output}};
    return ExitStatus::done;
}

}  // namespace

Command add_outer(Parser& program) {
    const auto options = std::make_shared<OuterOptions>();
    Parser parser =
        program.add_subcommand("outer", "Write the outer surface of a mesh whose parts overlap or lie in each other");
    parser
        .add("MESH", options->mesh, "the mesh: .off, .obj, .stl or .ply; several files are one body; or a scene, .json")
        .required();
    parser.add("-o,--output", options->output, "its outer surface: .off, .obj, .stl or .ply")
        .takes("FILE")
        .in_usage()
        .required();
    add_sign_option_of_outer(parser, options->sign);
    add_weld_option(parser, options->reading);
    add_skip_option(parser, options->reading);
    add_placement_options(parser, options->reading);
    parser.set_footer(
        "The outer surface is the boundary of what the sign of the mesh says is inside: parts of faces within others\n"
        "are left out, and faces are cut where they meet. Distances to it are those to the union of the parts.\n"
        "A .ply file has the property given_face: the number of the face as given, of which a triangle is a part.\n"
        "In place of meshes, a file .json has many bodies with poses (docs/scenes.md); given_face is then that of the\n"
        "face's body.\n\n"
        "Examples:\n"
        "  clsdf outer robot.stl -o outer.ply\n"
        "  clsdf outer housing.stl lid.stl -o outer.ply && clsdf compute outer.ply -o union.nrrd");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

#include "command.hpp"
#include "output.hpp"

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <memory>

namespace {

struct ShapeOptions {
    std::string name;
    std::string output;
    bool list = false;
    bool quiet = false;
};

void list_shapes() {
    std::string text;
    for (const clsdf::ShapeName& shape : clsdf::shape_names())
        text += fmt::format("{:<14}{}\n", shape.name, shape.description);
    print_result(text);
}

ExitStatus run(const ShapeOptions& options) {
    if (options.list) {
        list_shapes();
        return ExitStatus::done;
    }
    if (options.name.empty() || options.output.empty())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "a shape needs its NAME and -o FILE; \"clsdf shape --list\" prints the names");
    const clsdf::Mesh mesh = clsdf::make_shape(options.name);
    clsdf::write_mesh(mesh, options.output);
    if (!options.quiet)
        fmt::print(stderr, "{}: {} vertices, {} triangles -> {}\n", options.name, mesh.vertices().size(),
                   mesh.triangles().size(), options.output);
    return ExitStatus::done;
}

}  // namespace

Command add_shape(CLI::App& program) {
    const auto options = std::make_shared<ShapeOptions>();
    CLI::App* parser =
        program.add_subcommand("shape", "Write a mesh made by code: sphere6, torus, knot, seashell, ...");
    parser->add_option("NAME", options->name, "the shape; see --list");
    parser->add_option("-o,--output", options->output, "the mesh file: .off, .obj, .stl or .ply")->type_name("FILE");
    parser->add_flag("--list", options->list, "print the names and what they are");
    parser->add_flag("--quiet", options->quiet, "print errors only");
    parser->footer(
        "Examples:\n"
        "  clsdf shape --list\n"
        "  clsdf shape sphere6 -o sphere6.off\n"
        "  clsdf shape knot -o knot.stl && clsdf compute knot.stl -o knot.nrrd");
    return {parser, [options] { return run(*options); }};
}

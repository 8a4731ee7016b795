#include "command.hpp"
#include "interruption.hpp"
#include "report.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <memory>

namespace {

struct ShapeOptions {
    std::string name;
    std::string output;
    bool list = false;
};

void list_shapes(Report& report) {
    std::string text;
    for (const clsdf::ShapeName& shape : clsdf::shape_names()) {
        text += fmt::format("{:<14}{}\n", shape.name, shape.description);
        report.result["shapes"].push_back({{"name", shape.name}, {"description", shape.description}});
    }
    if (!report.json) print_result(text);
}

ExitStatus run(const ShapeOptions& options, Report& report) {
    if (options.list) {
        list_shapes(report);
        return ExitStatus::done;
    }
    if (options.name.empty() || options.output.empty())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "a shape needs its name and -o FILE; \"clsdf shape --list\" prints the names");
    const clsdf::Mesh mesh = clsdf::make_shape(options.name);
    clsdf::write_mesh(mesh, options.output);
    output_is_written();
    report.print("mesh    {}: {} vertices, {} triangles\nwrote   {}\n", options.name, mesh.vertices().size(),
                 mesh.triangles().size(), options.output);
    report.result = {{"shape", options.name},
                     {"vertices", mesh.vertices().size()},
                     {"triangles", mesh.triangles().size()},
                     {"output", options.output}};
    return ExitStatus::done;
}

}  // namespace

Command add_shape(Parser& program) {
    const auto options = std::make_shared<ShapeOptions>();
    Parser parser = program.add_subcommand("shape", "Write a mesh made by code: sphere6, torus, knot and others");
    parser.add("SHAPE", options->name, "the shape; see --list").in_usage();
    parser.add("-o,--output", options->output, "the mesh file: .off, .obj, .stl or .ply").takes("FILE").in_usage();
    parser.add("--list", options->list, "print the names and their descriptions")
        .excludes("SHAPE")
        .excludes("--output");
    parser.set_footer(
        "Examples:\n"
        "  clsdf shape --list\n"
        "  clsdf shape sphere6 -o sphere6.off\n"
        "  clsdf shape knot -o knot.stl && clsdf compute knot.stl -o knot.nrrd");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

#include "command.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"
#include "scene_file.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Stopwatch;
using clsdf::Vec3;

struct QueryOptions {
    std::string mesh;
    std::vector<std::string> more;  ///< further files of the mesh, and last the points
    MeshReading reading;
    std::string output;
    std::string half_width = "full";
    SignChoice sign;
    std::vector<std::string> with;
    bool positive_inside = false;
    bool refuse_unusable_points = false;
    bool winding = false;
    std::string device;

    std::vector<std::string> meshes() const { return mesh_files(mesh, more); }
    const std::string& points() const { return more.back(); }
};

/// A mesh, or many bodies.
struct Asked {
    std::optional<SceneFile> scene{};
    SceneMeshes bodies{};  ///< the meshes, one if there is no scene

    const clsdf::Mesh& mesh() const { return bodies.meshes[0]; }
};

/// The outputs of all points, and what making them took.
struct Found {
    clsdf::Field values;         ///< of a grid of one row
    std::vector<float> winding;  ///< empty unless asked for
    clsdf::TransformStatistics statistics;
    clsdf::SignRule sign = clsdf::SignRule::none;  ///< of the mesh
    Json bodies;                                   ///< of a scene
    bool has_sign = false;
    clsdf::Topology topology;  ///< of the mesh
    std::string device_name;
    std::string device_platform;
    double seconds = 0;
};

/// In the mesh's units; a voxel of points is 1/256 of the mesh's longest side.
double limit_of(const QueryOptions& options, const Asked& asked) {
    const clsdf::Length length = clsdf::Length::parse(options.half_width, "--half-width");
    if (asked.scene) {
        if (!length.is_infinite() && length.unit != clsdf::Length::Unit::mesh)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("--half-width: '{}' follows from the size of a mesh, and a scene has many; give it "
                                    "in the scene's units",
                                    options.half_width));
        return length.value;
    }
    const double longest = asked.mesh().box().longest_side();
    return length.resolve(longest > 0 ? longest / 256 : 1, longest);
}

/// The columns of outputs: in a scene the nearest body always is one.
clsdf::OutputSet outputs_of(const QueryOptions& options, const Asked& asked) {
    clsdf::OutputSet outputs = parse_outputs(options.with) | clsdf::Output::distance;
    if (asked.scene) outputs.insert(clsdf::Output::body);
    return outputs;
}

Asked read_bodies(const QueryOptions& options, Report& report) {
    Asked asked;
    if (!std::ranges::any_of(options.meshes(), is_scene_file)) {
        asked.bodies.meshes.push_back(read_body(options.meshes(), options.reading, report));
        return asked;
    }
    refuse_beside_scene(options.meshes(), options.sign, options.with);
    asked.scene = read_scene(options.mesh);
    asked.bodies = read_meshes(*asked.scene, options.reading, report);
    return asked;
}

void find_in_scene(const QueryOptions& options, const clsdf::Device& device, const Asked& asked,
                   std::span<const Vec3> points, double half_width, const clsdf::CallOptions& call, Found& found) {
    const clsdf::Scene scene =
        make_scene(*asked.scene, asked.bodies, device, call, parse_surface(options.sign.surface));
    found.bodies = describe(*asked.scene, asked.bodies, scene);
    found.has_sign = scene.has_sign();
    found.statistics = scene.query(points, half_width, {found.values.targets()}, call);
    if (!options.winding) return;
    std::vector<double> sums(points.size());
    scene.winding(points, sums, call);
    for (const double sum : sums) found.winding.push_back(static_cast<float>(sum));
}

Found find(const QueryOptions& options, const clsdf::Device& device, const Asked& asked, std::span<const Vec3> points,
           double half_width, clsdf::CallOptions call) {
    Found found;
    const clsdf::TransformOptions transform_options = transform_options_of(options.sign);
    call.refuse_unusable_points = options.refuse_unusable_points;
    for (const clsdf::OutputInfo& info : clsdf::output_table())
        if (outputs_of(options, asked).contains(info.output)) found.values.resize(info.output, points.size());
    const Stopwatch watch;
    if (asked.scene) {
        find_in_scene(options, device, asked, points, half_width, call, found);
    } else {
        const clsdf::DistanceTransform transform(device, asked.mesh(), transform_options, call);
        found.sign = transform.sign();
        found.topology = transform.topology();
        found.has_sign = transform.sign() != clsdf::SignRule::none;
        found.statistics = transform.query(points, half_width, found.values.targets(), call);
        if (options.winding) {
            found.winding.resize(points.size());
            transform.winding(points, found.winding, call);
        }
    }
    found.seconds = std::max(0.0, watch.seconds() - found.statistics.compile_seconds);
    found.device_name = device.name();
    found.device_platform = device.platform();
    return found;
}

ExitStatus run(const QueryOptions& options, Report& report) {
    clsdf::check_points_path(options.output);
    const std::vector<std::string> meshes = options.meshes();
    keep_mesh(meshes, options.output);
    keep_input(options.points(), options.output, "file of points");
    const clsdf::Device device = open_device(options.device, report);
    const Stopwatch read;
    const Asked asked = read_bodies(options, report);
    if (asked.scene) keep_mesh(asked.scene->files(), options.output);
    const std::vector<Vec3> points =
        clsdf::read_points(options.points(), [&](const std::string& message) { report.warn(message); });
    const double read_seconds = read.seconds();
    const double half_width = limit_of(options, asked);
    const clsdf::Mesh& mesh = asked.mesh();
    const clsdf::FaceGroups* const groups = wants_groups(options.with, mesh) ? &mesh.groups() : nullptr;

    Found found;
    run_call(
        report,
        {.explain = [&](const Error& error) { return with_file(error, "point ", options.points()); },
         .too_large = fmt::format("the outputs of {} points do not fit the memory; divide the points", points.size())},
        [&](const RunningCall& running) { found = find(options, device, asked, points, half_width, running.call); });
    if (options.positive_inside && asked.scene && !found.has_sign)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}: no body has a sign, and --positive-inside needs one: leave that out, or choose "
                                "another sign in the file",
                                options.mesh));
    if (options.positive_inside && !asked.scene)
        require_sign(found.sign, found.topology, meshes, options.sign, "--positive-inside needs", "leave that out");
    const std::span<const float> distance = found.values.slab().distance();
    const auto inside = static_cast<std::size_t>(
        std::count_if(distance.begin(), distance.end(), [](float d) { return std::signbit(d); }));
    if (options.positive_inside) found.values.negate();
    const Stopwatch write;
    clsdf::write_points(points, found.values.slab(), options.output, outputs_of(options, asked), found.winding, groups);
    output_is_written();
    const double write_seconds = write.seconds();

    if (!report.quiet) {
        if (asked.scene)
            report.print("scene   {}: {} bodies, {} triangles in their meshes\n", options.mesh,
                         asked.bodies.mesh_of.size(), asked.bodies.triangles());
        else
            report.print("mesh    {}: {} vertices, {} triangles\n", paths_of(meshes), mesh.vertices().size(),
                         mesh.triangles().size());
        if (groups != nullptr) report.print("groups  {}\n", human(*groups));
        report.print("device  {} ({})\n", found.device_name, found.device_platform);
        report.print(
            "done    {} points in {:.3f} s, {}\n", points.size(), found.seconds,
            found.has_sign ? fmt::format("{} of them inside", inside) : "without a sign: the mesh has no inside");
        report.print("wrote   {}\n", options.output);
    }
    report.result = {{"mesh", paths_of(meshes)},
                     {"points", options.points()},
                     {"count", points.size()},
                     {"unusable_points", found.statistics.unusable_points},
                     {"half_width", half_width},
                     {"sign", asked.scene ? Json() : Json(name_of(found.sign))},
                     {"inside", inside},
                     {"positive_inside", options.positive_inside},
                     {"winding", options.winding},
                     {"device", {{"name", found.device_name}, {"platform", found.device_platform}}},
                     {"seconds",
                      {{"read", read_seconds},
                       {"compile", found.statistics.compile_seconds},
                       {"set_up", found.statistics.polyhedra_seconds},
                       {"nearest", found.statistics.field_seconds},
                       {"sign", found.statistics.work->sign_seconds},
                       {"query", found.seconds},
                       {"write", write_seconds}}},
                     {"first_use", found.statistics.first_use},
                     {"output", options.output}};
    if (groups != nullptr) report.result["groups"] = groups->names;
    if (asked.scene) report.result["bodies"] = found.bodies;
    return ExitStatus::done;
}

}  // namespace

Command add_query(Parser& program) {
    const auto options = std::make_shared<QueryOptions>();
    Parser parser = program.add_subcommand("query", "Compute distances at points");
    add_mesh_and_argument(parser, options->mesh, "POINTS", options->more, "the points, last: .npy, .csv or .ply");
    parser.add("-o,--output", options->output, "a row for each point: .npy, .csv or .ply").takes("RESULT").required();
    parser.add("--half-width", options->half_width, "how far the surface is looked for").takes_text("LENGTH");
    add_outputs_and_groups_option(parser, options->with);
    add_sign_options(parser, options->sign);
    add_surface_option(parser, options->sign.surface);
    parser.add("--winding", options->winding, "a column of generalised winding numbers, too");
    parser.add("--refuse-unusable-points", options->refuse_unusable_points,
               "fail if a point is not finite or too far from the mesh");
    add_positive_inside_option(parser, options->positive_inside);
    add_placement_options(parser, options->reading);
    add_group_option(parser, options->reading);
    add_weld_option(parser, options->reading);
    add_skip_option(parser, options->reading);
    add_device_option(parser, options->device, "what computes");
    parser.set_footer(
        "A LENGTH is 10% (of the longest side of the mesh's box), 3v (voxels of 1/256 of that side), 0.05 (the\n"
        "mesh's units) or full (without end). Farther points have the distance LENGTH, with their sign.\n"
        "A point that is not finite has the distance nan, and a warning has the number of such points.\n"
        "The winding number says how clearly a point is inside: 1 or -1 inside a closed mesh, 0 outside, and values\n"
        "between near the holes of an open one.\n"
        "In place of meshes, a file .json has many bodies with poses (docs/scenes.md). The result has the nearest\n"
        "body of each point, too.\n\n"
        "Examples:\n"
        "  clsdf query bunny.off particles.npy -o distances.npy\n"
        "  clsdf query part.stl scan.ply -o deviation.csv --with closest,triangle\n"
        "  clsdf query inlet.stl wall.stl cells.csv -o patches.csv --with group\n"
        "  clsdf query bunny.off particles.csv -o contacts.csv --half-width 0.01 --with gradient\n"
        "  clsdf query arm.json obstacles.csv -o clearance.csv --with closest");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

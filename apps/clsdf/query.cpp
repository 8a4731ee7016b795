#include "command.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

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
    std::string points;
    std::string output;
    std::string within = "full";
    std::string sign = "auto";
    std::vector<std::string> with;
    std::string device;
};

namespace detail {
template <typename Element>
using ArrayOf = std::vector<Element>;
}

/// The outputs of all points, and what making them took.
struct Found {
    clsdf::PerOutput<detail::ArrayOf> values;
    clsdf::FieldSlab slab;
    clsdf::TransformStatistics statistics;
    clsdf::SignRule sign = clsdf::SignRule::none;
    std::string device_name;
    std::string device_platform;
    double seconds = 0;
};

/// In the mesh's units; a voxel of points is 1/256 of the mesh's longest side.
double limit_of(const QueryOptions& options, const clsdf::Mesh& mesh) {
    const double longest = mesh.box().longest_side();
    return parse_length("--within", options.within).resolve(longest > 0 ? longest / 256 : 1, longest);
}

clsdf::OutputTargets make_room(const clsdf::Outputs& outputs, std::size_t points, Found& found) {
    clsdf::OutputTargets targets;
    found.values.distance.resize(points);
    targets.distance = found.values.distance;
    clsdf::visit_extras(
        [&](const char*, bool wanted, auto& values, clsdf::OutputTarget& target, std::size_t bytes) {
            if (!wanted) return;
            values.resize(points * bytes / sizeof(values[0]));
            target = values;
        },
        outputs, found.values, targets, clsdf::output_bytes);
    clsdf::visit_outputs([](const char*, const auto& values, auto& span) { span = values; }, found.values, found.slab);
    return targets;
}

void find(const QueryOptions& options, const clsdf::Device& device, const clsdf::Mesh& mesh,
          std::span<const Vec3> points, double within, Report& report, const std::stop_token& stop, Found& found) {
    ProgressBar progress(!report.quiet);
    clsdf::TransformOptions transform_options;
    transform_options.sign = parse_sign(options.sign);
    transform_options.log = [&](const std::string& message) {
        progress.clear();
        report.warn(message);
    };
    clsdf::CallOptions call;
    call.should_stop = [&stop] { return stop.stop_requested(); };
    call.progress = [&](double fraction) { progress.show(fraction); };
    call.compiling = [&](const clsdf::Compilation& step) { progress.show(text_of(step)); };
    call.statistics = &found.statistics;
    const clsdf::OutputTargets targets = make_room(parse_outputs(options.with), points.size(), found);
    const Stopwatch watch;
    const clsdf::DistanceTransform transform(device, mesh, transform_options, call);
    found.sign = transform.sign();
    transform.query(points, within, targets, call);
    found.seconds = std::max(0.0, watch.seconds() - found.statistics.compile_seconds);
    found.device_name = device.name();
    found.device_platform = device.platform();
}

Found find_unless_interrupted(const QueryOptions& options, const clsdf::Device& device, const clsdf::Mesh& mesh,
                              std::span<const Vec3> points, double within, Report& report) {
    const Interruption interruption;
    try {
        Found found;
        find(options, device, mesh, points, within, report, interruption.token(), found);
        if (!interruption.token().stop_requested()) return found;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("the outputs of {} points do not fit the memory; divide the points", points.size()));
    } catch (const Error& error) {
        if (!interruption.token().stop_requested()) throw with_file(error, "point ", options.points);
    }
    throw Error(ErrorCode::cancelled, "cancelled; nothing was written");
}

ExitStatus run(const QueryOptions& options, Report& report) {
    clsdf::check_points_output(options.output);
    keep_input(options.mesh, options.output, "mesh");
    keep_input(options.points, options.output, "file of points");
    const clsdf::Device device = open_device(options.device);
    const Stopwatch read;
    const clsdf::Mesh mesh = clsdf::read_mesh(options.mesh);
    const std::vector<Vec3> points = clsdf::read_points(options.points);
    const double read_seconds = read.seconds();
    const double within = limit_of(options, mesh);

    const Found found = find_unless_interrupted(options, device, mesh, points, within, report);
    const Stopwatch write;
    clsdf::write_points(points, found.slab, options.output, parse_outputs(options.with));
    output_is_written();
    const double write_seconds = write.seconds();

    const std::vector<float>& distance = found.values.distance;
    const auto inside = static_cast<std::size_t>(
        std::count_if(distance.begin(), distance.end(), [](float d) { return std::signbit(d); }));
    if (!report.quiet) {
        report.print("mesh    {}: {} vertices, {} triangles\n", options.mesh, mesh.vertices().size(),
                     mesh.triangles().size());
        report.print("device  {} ({})\n", found.device_name, found.device_platform);
        report.print("done    {} points in {:.3f} s, {} of them inside\n", points.size(), found.seconds, inside);
        report.print("wrote   {}\n", options.output);
    }
    report.result = {{"mesh", options.mesh},
                     {"points", options.points},
                     {"count", points.size()},
                     {"within", std::isinf(within) ? nlohmann::ordered_json() : nlohmann::ordered_json(within)},
                     {"sign", name_of(found.sign)},
                     {"inside", inside},
                     {"device", {{"name", found.device_name}, {"platform", found.device_platform}}},
                     {"seconds",
                      {{"read", read_seconds},
                       {"compile", found.statistics.compile_seconds},
                       {"set_up", found.statistics.polyhedra_seconds},
                       {"nearest", found.statistics.field_seconds},
                       {"sign", found.statistics.sign_seconds},
                       {"query", found.seconds},
                       {"write", write_seconds}}},
                     {"first_use", found.statistics.first_use},
                     {"output", options.output}};
    return ExitStatus::done;
}

}  // namespace

Command add_query(CLI::App& program) {
    const auto options = std::make_shared<QueryOptions>();
    CLI::App* parser = program.add_subcommand("query", "Compute distances at points");
    parser->add_option("MESH", options->mesh, "the mesh: .off, .obj, .stl or .ply")->required();
    parser->add_option("POINTS", options->points, "the points: .npy, .csv or .ply")->required();
    parser->add_option("-o,--output", options->output, "a row for each point: .npy, .csv or .ply")
        ->type_name("RESULT")
        ->required();
    parser->add_option("--within", options->within, "how far the surface is looked for")
        ->check(not_empty())
        ->type_name("LENGTH")
        ->capture_default_str();
    add_outputs_option(*parser, options->with);
    add_sign_option(*parser, options->sign);
    add_device_option(*parser, options->device, "what computes");
    parser->footer(
        "A LENGTH is 10% (of the longest side of the mesh's box), 3v (voxels of 1/256 of that side), 0.05 (the\n"
        "mesh's units) or full (without end). Farther points have the distance LENGTH, with their sign.\n\n"
        "Examples:\n"
        "  clsdf query bunny.off particles.npy -o distances.npy\n"
        "  clsdf query part.stl scan.ply -o deviation.csv --with closest,triangle\n"
        "  clsdf query bunny.off particles.csv -o contacts.csv --within 0.01 --with gradient");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

#include "command.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Stopwatch;

struct RayCallOptions {
    std::string mesh;
    std::vector<std::string> more;  ///< further files of the mesh, and last the rays
    MeshReading reading;
    std::string output;
    std::string hits = "walls";
    double limit = std::numeric_limits<double>::infinity();
    std::size_t most = 1;
    bool count = false;
    std::vector<std::string> with;
    SignChoice sign;
    bool refuse_unusable_rays = false;
    std::string device;

    std::vector<std::string> meshes() const { return mesh_files(mesh, more); }
    const std::string& rays() const { return more.back(); }
};

struct Found {
    std::vector<double> t;
    std::vector<std::uint32_t> triangles, counts;
    clsdf::TransformStatistics statistics;
    clsdf::SignRule sign = clsdf::SignRule::none;
    double seconds = 0;
};

Found find(const RayCallOptions& options, const clsdf::Device& device, const clsdf::Mesh& mesh,
           const clsdf::RayRows& rays, clsdf::CallOptions call) {
    Found found;
    const clsdf::TransformOptions transform_options = transform_options_of(options.sign);
    call.refuse_unusable_points = options.refuse_unusable_rays;
    const std::size_t count = rays.origins.size();
    found.t.resize(count * options.most);
    found.triangles.resize(count * options.most);
    if (options.count) found.counts.resize(count);
    const Stopwatch watch;
    const clsdf::DistanceTransform transform(device, mesh, transform_options, call);
    found.sign = transform.sign();
    if (parse_hits(options.hits) == clsdf::Hits::walls)
        require_sign(found.sign, transform.topology(), options.meshes(), options.sign, "--hits walls needs",
                     "choose --hits faces");
    clsdf::RayTargets targets{.most = options.most, .t = found.t, .triangles = found.triangles};
    if (options.count && count > 0) targets.counts = found.counts;
    found.statistics =
        transform.rays(rays.origins, rays.directions, {parse_hits(options.hits), options.limit}, targets, call);
    found.seconds = watch.seconds();
    return found;
}

ExitStatus run(const RayCallOptions& options, Report& report) {
    clsdf::check_rays_path(options.output);
    const std::vector<std::string> meshes = options.meshes();
    keep_mesh(meshes, options.output);
    keep_input(options.rays(), options.output, "file of rays");
    const clsdf::Device device = open_device(options.device, report);
    const Stopwatch read;
    const clsdf::Mesh mesh = read_body(meshes, options.reading, report);
    const clsdf::RayRows rays = clsdf::read_rays(options.rays());
    const double read_seconds = read.seconds();
    const clsdf::FaceGroups* const groups = wants_groups(options.with, mesh) ? &mesh.groups() : nullptr;

    const std::size_t count = rays.origins.size();
    Found found;
    run_call(report,
             {.explain = [&](const Error& error) { return with_file(error, "ray ", options.rays()); },
              .too_large = fmt::format("the hits of {} rays do not fit the memory; divide the rays", count)},
             [&](const RunningCall& running) { found = find(options, device, mesh, rays, running.call); });
    std::size_t hit = 0;
    for (std::size_t i = 0; i < count; ++i) hit += std::isfinite(found.t[i * options.most]) ? 1U : 0U;
    const Stopwatch write;
    clsdf::write_rays(rays, {options.most, found.t, found.triangles, found.counts}, options.output, groups);
    output_is_written();
    const double write_seconds = write.seconds();

    if (!report.quiet) {
        report.print("mesh    {}: {} vertices, {} triangles\n", paths_of(meshes), mesh.vertices().size(),
                     mesh.triangles().size());
        if (groups != nullptr) report.print("groups  {}\n", human(*groups));
        report.print("done    {} rays in {:.3f} s, {} of them meet {}\n", count, found.seconds, hit, options.hits);
        report.print("wrote   {}\n", options.output);
    }
    report.result = {{"mesh", paths_of(meshes)},
                     {"rays", options.rays()},
                     {"count", count},
                     {"unusable_rays", found.statistics.unusable_points},
                     {"hits", options.hits},
                     {"most", options.most},
                     {"sign", name_of(found.sign)},
                     {"hit", hit},
                     {"seconds",
                      {{"read", read_seconds},
                       {"set_up", found.statistics.polyhedra_seconds},
                       {"search", found.statistics.field_seconds},
                       {"rays", found.seconds},
                       {"write", write_seconds}}},
                     {"output", options.output}};
    if (std::isfinite(options.limit)) report.result["limit"] = options.limit;
    if (groups != nullptr) report.result["groups"] = groups->names;
    return ExitStatus::done;
}

}  // namespace

Command add_rays(Parser& program) {
    const auto options = std::make_shared<RayCallOptions>();
    Parser parser = program.add_subcommand("rays", "Find where rays meet the surface");
    add_mesh_and_argument(parser, options->mesh, "RAYS", options->more, "the rays, last: .npy or .csv");
    parser.add("-o,--output", options->output, "a row for each ray: .npy or .csv").takes("RESULT").required();
    add_hits_option(parser, options->hits);
    parser.add("--limit", options->limit, "hits beyond are left out, in lengths of the direction")
        .takes_number_of_0_to_infinity("T");
    parser.add("--most", options->most, "hits of each ray, the first ones").takes_whole_number("COUNT", 1, 1U << 20);
    parser.add("--count", options->count, "a column with the number of all hits, too");
    add_wall_groups_option(parser, options->with);
    add_sign_options(parser, options->sign);
    add_surface_option(parser, options->sign.surface);
    parser.add("--refuse-unusable-rays", options->refuse_unusable_rays,
               "fail if an origin is not finite, or a direction is 0 or not finite");
    add_placement_options(parser, options->reading);
    add_group_option(parser, options->reading);
    add_weld_option(parser, options->reading);
    add_skip_option(parser, options->reading);
    add_device_option(parser, options->device, "what describes the mesh");
    parser.set_footer(
        "A ray is an origin and a direction of any length: six numbers a row of .npy, the columns x, y, z, dx, dy and\n"
        "dz of .csv. Its hits are at the origin + t times the direction; t is inf if nothing is met, and nan if the "
        "ray\n"
        "is not usable. No ray slips through an edge or a vertex. A point on a wall is outside, so that a ray that\n"
        "leaves the body there does not meet it; --hits faces has a hit at t = 0.\n\n"
        "Examples:\n"
        "  clsdf rays bunny.off beams.csv -o hits.csv\n"
        "  clsdf rays part.stl beams.npy -o hits.npy --limit 2 --most 4 --count\n"
        "  clsdf rays sheet.obj beams.npy -o hits.npy --hits faces");
    return {parser, [options](Report& report) { return run(*options, report); }};
}

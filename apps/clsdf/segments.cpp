#include "segments.hpp"

#include "devices.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"

#include "core/stopwatch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>

void require_memory_of_sides(const clsdf::Grid& grid) {
    const auto& [nx, ny, nz] = grid.size;
    // A bit for each sample, and a byte in the file.
    require_memory(1.125 * static_cast<double>(nx) * static_cast<double>(ny) * static_cast<double>(nz),
                   fmt::format("the sides of {} x {} x {} samples", nx, ny, nz));
}

void add_segment_options(Parser& parser, SegmentOptions& options, const char* output) {
    ComputeOptions& own = options.grid;
    own.margin = "5%";
    add_mesh_argument(parser, own.mesh);
    parser.add("-o,--output", own.output, output).takes("RESULT").required();
    add_grid_options(parser, own, "room around the mesh");
    parser.begin_group("Options");
    add_wall_groups_option(parser, own.with);
    add_sign_options(parser, own.sign);
    add_surface_option(parser, own.sign.surface);
    add_placement_options(parser, own.reading);
    add_group_option(parser, own.reading);
    add_weld_option(parser, own.reading);
    add_skip_option(parser, own.reading);
    add_device_option(parser, own.device, "what computes");
}

SegmentRun run_segments(const SegmentOptions& options, Report& report,
                        const std::function<void(const clsdf::DistanceTransform&, const clsdf::Grid&,
                                                 const clsdf::CallOptions&, clsdf::TransformStatistics&)>& find) {
    const ComputeOptions& own = options.grid;
    const ComputeRequest request(own);
    keep_mesh(own.mesh, own.output);
    const clsdf::Device device = open_device(own.device, report);
    std::optional<clsdf::Mesh> mesh = read_body(own.mesh, own.reading, report);
    const std::size_t vertices = mesh->vertices().size(), triangles = mesh->triangles().size();
    SegmentRun run;
    if (wants_groups(own.with, *mesh)) run.groups = mesh->groups();
    run.box = mesh->box();
    run.grid = request.grid_around(run.box);
    report.warn(warning_of_size(run.grid, run.box));
    run.device = device.name();
    run_call(report, {.explain = [&](const clsdf::Error& error) { return with_remedy(own, error); }},
             [&](const RunningCall& running) {
                 const clsdf::Stopwatch watch;
                 const clsdf::DistanceTransform transform(device, *mesh, transform_options_of(own.sign), running.call);
                 mesh.reset();  // the transform has a copy
                 run.sign = transform.sign();
                 clsdf::TransformStatistics statistics;
                 find(transform, run.grid, running.call, statistics);
                 run.seconds = std::max(0.0, watch.seconds() - statistics.compile_seconds);
             });
    if (!report.quiet) {
        report.print("mesh    {}: {} vertices, {} triangles\n", paths_of(own.mesh), vertices, triangles);
        if (run.groups) report.print("groups  {}\n", human(*run.groups));
        report.print("grid    {} x {} x {} samples\n", run.grid.size[0], run.grid.size[1], run.grid.size[2]);
    }
    return run;
}

Json describe(const SegmentOptions& options, const SegmentRun& run) {
    Json result{{"mesh", paths_of(options.grid.mesh)},
                {"grid", describe(run.grid)},
                {"sign", name_of(run.sign)},
                {"device", run.device},
                {"seconds", run.seconds},
                {"output", options.grid.output}};
    if (run.groups) result["groups"] = run.groups->names;
    return result;
}

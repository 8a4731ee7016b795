#include "compute.hpp"

#include "command.hpp"
#include "core/stopwatch.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"
#include "scene_file.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Stopwatch;

/// Throws Error(invalid_argument or unsupported) for options that a scene's file has, or that are of one mesh.
void refuse_options_of_meshes(const ComputeOptions& options, const ComputeRequest& request) {
    refuse_beside_scene(options.mesh, options.sign, options.with);
    const char* const option = options.sparse                                  ? "--sparse"
                               : request.scan != clsdf::Scan::bricks           ? "--scan or --polyhedra"
                               : request.polyhedra != clsdf::Polyhedra::leaned ? "--polyhedra"
                                                                               : nullptr;
    if (option != nullptr)
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: '{}' is a scene, whose fields are dense and exact; leave it out", option,
                                options.mesh.front()));
    for (const clsdf::Output output : {clsdf::Output::site, clsdf::Output::barycentric})
        if (request.surface == clsdf::Surface::outer && request.outputs.contains(output))
            throw Error(
                ErrorCode::unsupported,
                fmt::format("--with {}: it is not known of a field of a scene with --surface outer, whose faces "
                            "are cut; leave it out",
                            clsdf::info_of(output).name));
    if (!options.output.empty() && clsdf::stores_sparse_fields_only(options.output))
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: this format stores sparse fields alone, and '{}' is a scene, whose fields are "
                                "dense; choose .nrrd, .npy, .vti, .vtkhdf, .h5 or .sdf",
                                options.output, options.mesh.front()));
}

clsdf::Field compute(const SceneFile& file, const SceneMeshes& meshes, const ComputeOptions& options,
                     const ComputeRequest& request, const clsdf::Device& device, Report& report,
                     const clsdf::CallOptions& call, clsdf::TransformStatistics& statistics, Json& bodies) {
    const clsdf::Scene scene = make_scene(file, meshes, device, call, request.surface);
    bodies = describe(file, meshes, scene);
    if ((options.positive_inside || request.exact_signs) && !scene.has_sign())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}: no body has a sign, and {} needs one: leave that out, or choose another sign in "
                                "the file",
                                file.path, options.positive_inside ? "--positive-inside" : "--exact-signs"));
    const clsdf::Box box = scene.box();
    const clsdf::Grid grid = request.grid_around(box);
    const clsdf::Band band = request.band_on(grid, box);
    report.warn(warning_of_size(grid, box));
    report.warn(warning_between_samples(grid, box, scene.sign()));
    report.warn(warning_of_narrow_band(grid, band, scene.sign()));
    if (options.positive_inside && band.has_signs_only)
        throw Error(ErrorCode::invalid_argument,
                    "--positive-inside: with --band 0 the field has the signs of zeros alone, and these are negative "
                    "inside; leave it out, or give the band a width");
    if (!report.quiet) {
        report.print("scene   {}: {} bodies, {} triangles in their meshes\n", file.path, scene.size(),
                     meshes.triangles());
        report.print("grid    {}\nband    {}\n", human(grid), human(band, grid.voxel()));
    }
    if (options.dry_run) {
        clsdf::Field none;
        none.grid = grid;
        none.band = band;
        none.sign = scene.sign();
        return none;
    }
    clsdf::Field field = scene.compute(grid, band, request.outputs, call, &statistics);
    field.mesh_name = std::filesystem::path(file.path).filename().string();
    report.warn(warning_of_empty_band(field, box, count_band_samples(field, field.slab())));
    if (options.positive_inside) field.negate();
    return field;
}

}  // namespace

ExitStatus compute_scene(const ComputeOptions& options, Report& report) {
    const ComputeRequest request(options);
    refuse_options_of_meshes(options, request);
    if (!options.output.empty())
        clsdf::check_field_path(options.output, request.outputs);
    else if (!options.dry_run)
        throw Error(ErrorCode::invalid_argument,
                    "state the output: -o FILE, with the ending .nrrd, .npy, .vti, .vtkhdf, .h5 or .sdf");
    const SceneFile file = read_scene(options.mesh.front());
    if (!options.output.empty()) keep_mesh(file.files(), options.output);
    const clsdf::Device device = open_device(options.device, report);
    const Stopwatch read;
    const SceneMeshes meshes = read_meshes(file, options.reading, report);
    const double read_seconds = read.seconds();

    const Stopwatch watch;
    clsdf::TransformStatistics statistics;
    Json bodies;
    clsdf::Field field;
    run_call(report, {}, [&](const RunningCall& running) {
        field = compute(file, meshes, options, request, device, report, running.call, statistics, bodies);
    });
    const double seconds = std::max(0.0, watch.seconds() - statistics.compile_seconds);
    report.result = {{"mesh", file.path},
                     {"bodies", bodies},
                     {"grid", describe(field.grid)},
                     {"band", describe(field.band)},
                     {"sign", name_of(field.sign)},
                     {"positive_inside", options.positive_inside}};
    if (request.surface == clsdf::Surface::outer) report.result["surface"] = "outer";
    if (options.dry_run) return ExitStatus::done;
    const std::size_t band_samples = count_band_samples(field, field.slab());
    const Stopwatch write;
    clsdf::write_field(field, options.output);
    output_is_written();
    if (!report.quiet) {
        report.print("device  {} ({})\n", device.name(), device.platform());
        report.print("done    {} samples in {:.3f} s, {} of them within the band's limits\n", field.grid.sample_count(),
                     seconds, band_samples);
        report.print("wrote   {}\n", options.output);
    }
    report.result.update({{"samples", field.grid.sample_count()},
                          {"band_samples", band_samples},
                          {"device", {{"name", device.name()}, {"platform", device.platform()}}},
                          {"seconds",
                           {{"read", read_seconds},
                            {"compile", statistics.compile_seconds},
                            {"field", seconds},
                            {"write", write.seconds()}}},
                          {"first_use", statistics.first_use},
                          {"output", options.output}});
    return ExitStatus::done;
}

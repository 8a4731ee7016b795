#include "compute_report.hpp"

#include "output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

using nlohmann::ordered_json;

namespace {

double field_bytes(const ComputeLayout& layout) {
    return static_cast<double>(layout.grid.sample_count()) * (layout.outputs.triangle ? 8 : 4);
}

// What a computation may use beside the field: polyhedra, lists and the program's compiler.
double working_bytes(const ComputeLayout& layout) {
    return 1024.0 * static_cast<double>(layout.mesh.triangles().size()) + 256.0 * 1024 * 1024;
}

const char* meaning_of(clsdf::SignRule rule) {
    switch (rule) {
        case clsdf::SignRule::nonzero:
            return "nonzero: negative where the winding number is not zero";
        case clsdf::SignRule::parity:
            return "parity: negative where a ray crosses the surface an odd number of times";
        default:
            return "none: the distance alone";
    }
}

ordered_json describe_layout(const ComputeLayout& layout) {
    return {{"mesh",
             {{"file", layout.mesh_file},
              {"name", layout.mesh.name()},
              {"vertices", layout.mesh.vertices().size()},
              {"triangles", layout.mesh.triangles().size()},
              {"lower", layout.mesh.box().lower},
              {"upper", layout.mesh.box().upper}}},
            {"grid", describe(layout.grid)},
            {"band", describe(layout.band)},
            {"sign", name_of(layout.sign)},
            {"warnings", layout.warnings}};
}

ordered_json ratio(std::size_t part, std::size_t whole) {
    return whole == 0 ? ordered_json() : ordered_json(static_cast<double>(part) / static_cast<double>(whole));
}

}  // namespace

std::size_t count_band_samples(const clsdf::Field& field) {
    const auto outside = static_cast<float>(field.band.outside);
    const auto inside = -static_cast<float>(field.band.inside);
    return static_cast<std::size_t>(std::count_if(field.distance.begin(), field.distance.end(), [&](float distance) {
        return distance < outside && (field.sign == clsdf::SignRule::none || distance > inside);
    }));
}

void print_layout(const ComputeLayout& layout) {
    fmt::print(stderr, "mesh    {}: {} vertices, {} triangles\n", layout.mesh_file, layout.mesh.vertices().size(),
               layout.mesh.triangles().size());
    fmt::print(stderr, "grid    {}\n", human(layout.grid));
    fmt::print(stderr, "band    {}\n", human(layout.band, layout.grid.voxel()));
    fmt::print(stderr, "sign    {}\n", meaning_of(layout.sign));
}

void print_memory(const ComputeLayout& layout) {
    fmt::print(stderr, "memory  {} for the field, and up to {} to compute it\n", human_bytes(field_bytes(layout)),
               human_bytes(working_bytes(layout)));
}

void print_outcome(const ComputeLayout& layout, const Computation& computation) {
    const auto samples = static_cast<double>(layout.grid.sample_count());
    fmt::print(stderr, "device  {} ({})\n", computation.device_name, computation.device_platform);
    fmt::print(stderr, "done    in {:.3f} s: {} samples, {} of them in the band; {} samples a second\n",
               computation.compute_seconds, human_count(samples),
               human_count(static_cast<double>(computation.band_samples)),
               human_count(samples / computation.compute_seconds));
    fmt::print(stderr, "wrote   {} ({})\n", computation.output, human_bytes(field_bytes(layout)));
}

ordered_json describe_dry_run(const ComputeLayout& layout) {
    ordered_json result = describe_layout(layout);
    result["memory"] = {{"field_bytes", field_bytes(layout)}, {"working_bytes", working_bytes(layout)}};
    return result;
}

ordered_json describe(const ComputeLayout& layout, const Computation& computation) {
    const clsdf::TransformStatistics& statistics = computation.statistics;
    ordered_json result = describe_layout(layout);
    result["device"] = {{"name", computation.device_name}, {"platform", computation.device_platform}};
    result["seconds"] = {{"read", computation.read_seconds},       {"setup", computation.setup_seconds},
                         {"compute", computation.compute_seconds}, {"polyhedra", statistics.polyhedra_seconds},
                         {"lists", statistics.lists_seconds},      {"field", statistics.field_seconds},
                         {"write", computation.write_seconds}};
    result["samples_per_second"] = static_cast<double>(layout.grid.sample_count()) / computation.compute_seconds;
    result["statistics"] = {
        {"samples", layout.grid.sample_count()},
        {"band_samples", statistics.band_samples},
        {"triangles", statistics.triangles},
        {"box_polyhedra", statistics.box_polyhedra},
        {"saddle_vertices", statistics.saddle_vertices},
        {"point_sites", statistics.point_sites},
        {"coarse_pairs", statistics.coarse_pairs},
        {"coarse_bricks", statistics.coarse_bricks},
        {"brick_pairs", statistics.brick_pairs},
        {"samples_covered", statistics.samples_covered},
        {"lanes_evaluated", statistics.lanes_evaluated},
        {"device_bytes", statistics.device_bytes},
        {"samples_covered_per_band_sample", ratio(statistics.samples_covered, statistics.band_samples)},
        {"lanes_evaluated_per_band_sample", ratio(statistics.lanes_evaluated, statistics.band_samples)},
        {"box_polyhedra_per_triangle", ratio(statistics.box_polyhedra, statistics.triangles)}};
    result["output"] = computation.output;
    return result;
}

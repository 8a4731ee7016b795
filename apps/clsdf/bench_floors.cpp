#include "bench.hpp"
#include "output.hpp"

#include "benchmarks/stages.hpp"

#include <fmt/format.h>

#include <algorithm>

using clsdf::bench::Floors;
using clsdf::bench::Stages;
using clsdf::bench::Workload;
using nlohmann::ordered_json;

namespace {

double per_band_sample(std::size_t count, const Workload& workload) {
    return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(workload.list.samples.size(), 1));
}

std::string describe_floors(const Floors& floors) {
    return fmt::format(
        "store   {:.1f} GB/s, past the caches {}\nfma     {:.0f} GFLOP/s\nlaunch  {:.1f} us waited for, {:.2f} us in a "
        "row",
        floors.store_bytes_per_second / 1e9,
        floors.store_past_caches_bytes_per_second > 0
            ? fmt::format("{:.1f} GB/s", floors.store_past_caches_bytes_per_second / 1e9)
            : "not offered",
        floors.fma_per_second / 1e9, 1e6 * floors.launch_seconds, 1e6 * floors.launch_in_row_seconds);
}

ordered_json describe(const Floors& floors) {
    return {{"store_bytes_per_second", floors.store_bytes_per_second},
            {"store_past_caches_bytes_per_second", floors.store_past_caches_bytes_per_second},
            {"fma_operations_per_second", floors.fma_per_second},
            {"launch_seconds", floors.launch_seconds},
            {"launch_in_row_seconds", floors.launch_in_row_seconds}};
}

ordered_json describe(const Stages& stages, const Workload& workload) {
    const clsdf::TransformStatistics& counts = stages.counts;
    return {
        {"wall_seconds", {{"least", stages.whole.least}, {"median", stages.whole.median}, {"most", stages.whole.most}}},
        {"stages_seconds",
         {{"polyhedra", stages.polyhedra},
          {"lists", stages.lists},
          {"sign", stages.sign},
          {"bricks", stages.bricks},
          {"fill", stages.fill},
          {"transfer", stages.transfer},
          {"rest", stages.rest}}},
        {"store_floor_seconds", stages.store_floor},
        {"evaluation_floor_seconds", stages.evaluation_floor},
        {"part_of_floor", stages.part_of_floor()},
        {"coarse_bricks", counts.coarse_bricks},
        {"coarse_pairs", counts.coarse_pairs},
        {"brick_pairs", counts.brick_pairs},
        {"lanes_evaluated", counts.lanes_evaluated},
        {"lanes_evaluated_per_band_sample", per_band_sample(counts.lanes_evaluated, workload)},
        {"samples_covered_per_band_sample", per_band_sample(counts.samples_covered, workload)},
        {"box_polyhedra", counts.box_polyhedra},
        {"point_sites", counts.point_sites},
        {"device_bytes", counts.device_bytes},
        {"judgement", ::describe(stages.judgement)}};
}

std::vector<std::string> row_of(const Stages& stages, const Workload& workload) {
    const clsdf::TransformStatistics& counts = stages.counts;
    return {workload.name,
            workload.mesh_name,
            milliseconds(stages.whole.median),
            milliseconds(stages.polyhedra),
            milliseconds(stages.lists),
            milliseconds(stages.sign),
            milliseconds(stages.bricks),
            milliseconds(stages.fill),
            milliseconds(stages.transfer + stages.rest),
            milliseconds(stages.store_floor),
            milliseconds(stages.evaluation_floor),
            fmt::format("{:.1f}%", 100 * stages.part_of_floor()),
            human_count(static_cast<double>(counts.coarse_pairs)),
            human_count(static_cast<double>(counts.brick_pairs)),
            fmt::format("{:.1f}", per_band_sample(counts.lanes_evaluated, workload)),
            fmt::format("{:.2f}", per_band_sample(counts.samples_covered, workload)),
            fmt::format("{:.2g}", stages.judgement.max_error_voxels)};
}

}  // namespace

ordered_json run_bench_floors(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes = load_standard_meshes(options);
    const clsdf::Device device = options.open_device();
    ordered_json result = describe_run("floors", options, device);
    const Floors floors = clsdf::bench::measure_floors(device);
    result["floors"] = describe(floors);
    options.say(describe_floors(floors));
    BenchTable table({"job", "mesh", "whole, ms", "polyhedra", "lists", "sign", "bricks", "fill", "rest", "store floor",
                      "evaluation floor", "of the floor", "coarse pairs", "brick pairs", "evaluations per sample",
                      "within polyhedra", "max error, voxel"});
    result["rows"] = ordered_json::array();
    for_each_workload(options, meshes, device, [&](const Workload& workload) {
        const Stages stages = measure_stages(workload, device, floors, options.measure);
        table.add(row_of(stages, workload));
        ordered_json row = ::describe(workload);
        row.update(describe(stages, workload));
        result["rows"].push_back(std::move(row));
    });
    options.say("\n" + table.text());
    return result;
}

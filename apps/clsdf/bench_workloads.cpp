#include "bench.hpp"
#include "report.hpp"

#include "benchmarks/method.hpp"
#include "benchmarks/stages.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <algorithm>

using clsdf::bench::Entry;
using clsdf::bench::Floors;
using clsdf::bench::Layout;
using clsdf::bench::Measurement;
using clsdf::bench::split_triangles;
using clsdf::bench::Stages;
using clsdf::bench::Workload;

// The benchmarks of the standard workloads: peers and floors.

std::vector<NamedMesh> load_standard_meshes(const BenchOptions& options) {
    return options.load_meshes(options.quick ? std::vector<std::string>{"sphere4"} : clsdf::bench::standard_meshes());
}

void for_each_workload(const BenchOptions& options, const std::vector<NamedMesh>& meshes, const clsdf::Device& device,
                       const std::function<void(const Workload&)>& measure) {
    for (const NamedMesh& mesh : meshes)
        for (Layout layout : clsdf::bench::standard_layouts()) {
            // Triangles far smaller than voxels: the mesh split twice, of the first mesh only unless it is asked for.
            const bool split = layout.name == "W4";
            if (options.workloads.empty() ? split && &mesh != &meshes.front()
                                          : !contains(options.workloads, layout.name))
                continue;
            layout.resolution = options.scaled(layout.resolution);
            measure(make_workload(layout, mesh.name, split ? split_triangles(split_triangles(mesh.mesh)) : mesh.mesh,
                                  device));
        }
}

namespace {

std::string table_of(const std::vector<Measurement>& measurements) {
    BenchTable table({"method", "least, ms", "median", "most", "user + system", "memory, MB", "max error, voxel",
                      "wrong values", "wrong signs", "missed", "leaked", "judged", "calls", "note"});
    for (const Measurement& m : measurements) {
        const clsdf::bench::Spread wall = clsdf::bench::spread_of(m.wall);
        std::vector<std::string> row{
            m.method,
            milliseconds(wall.least),
            milliseconds(wall.median),
            milliseconds(wall.most),
            milliseconds(clsdf::bench::spread_of(m.processor).median),
            m.peak_bytes ? fmt::format("{:.0f}", static_cast<double>(*m.peak_bytes) / 1e6) : "-"};
        for (std::string& cell : cells_of(m.judgement)) row.push_back(std::move(cell));
        row.push_back(std::to_string(m.wall.size()));
        row.push_back(m.stride == 1 ? m.note
                                    : fmt::format("{}; one brick in {} computed, and scaled", m.note, m.stride));
        table.add(std::move(row));
    }
    return table.text();
}

Json describe(const Entry& entry) {
    return {
        {"name", entry.name}, {"version", entry.version}, {"there", entry.method != nullptr}, {"remedy", entry.remedy}};
}

}  // namespace

Json run_bench_peers(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes = load_standard_meshes(options);
    const clsdf::Device device = options.open_device();
    const std::vector<Entry> entries = clsdf::bench::all_methods(device);
    const std::vector<clsdf::bench::Method*> methods = options.choose(entries);
    Json result = describe_run("peers", options, device);
    result["methods"] = Json::array();
    for (const Entry& entry : entries)
        if (options.methods.empty() || contains(options.methods, entry.name))
            result["methods"].push_back(describe(entry));
    result["rows"] = Json::array();
    for_each_workload(options, meshes, device, [&](const Workload& workload) {
        const std::vector<Measurement> measurements = measure_in_turns(workload, methods, options.measure);
        options.say(fmt::format("\n{}\n\n{}", title_of(workload), table_of(measurements)));
        for (const Measurement& measurement : measurements) {
            Json row = ::describe(workload);
            row.update(::describe(measurement));
            result["rows"].push_back(std::move(row));
        }
    });
    return result;
}

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

Json describe(const Floors& floors) {
    return {{"store_bytes_per_second", floors.store_bytes_per_second},
            {"store_past_caches_bytes_per_second", floors.store_past_caches_bytes_per_second},
            {"fma_operations_per_second", floors.fma_per_second},
            {"launch_seconds", floors.launch_seconds},
            {"launch_in_row_seconds", floors.launch_in_row_seconds}};
}

Json describe(const Stages& stages, const Workload& workload) {
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
        {"coarse_bricks", counts.work->coarse_bricks},
        {"coarse_pairs", counts.work->coarse_pairs},
        {"brick_pairs", counts.work->brick_pairs},
        {"lanes_evaluated", counts.work->lanes_evaluated},
        {"lanes_evaluated_per_band_sample", per_band_sample(counts.work->lanes_evaluated, workload)},
        {"samples_covered_per_band_sample", per_band_sample(counts.work->samples_covered, workload)},
        {"box_polyhedra", counts.work->box_polyhedra},
        {"point_sites", counts.work->point_sites},
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
            human_count(static_cast<double>(counts.work->coarse_pairs)),
            human_count(static_cast<double>(counts.work->brick_pairs)),
            fmt::format("{:.1f}", per_band_sample(counts.work->lanes_evaluated, workload)),
            fmt::format("{:.2f}", per_band_sample(counts.work->samples_covered, workload)),
            fmt::format("{:.2g}", stages.judgement.max_error_voxels)};
}

}  // namespace

Json run_bench_floors(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes = load_standard_meshes(options);
    const clsdf::Device device = options.open_device();
    Json result = describe_run("floors", options, device);
    const Floors floors = clsdf::bench::measure_floors(device);
    result["floors"] = describe(floors);
    options.say(describe_floors(floors));
    BenchTable table({"job", "mesh", "whole, ms", "polyhedra", "lists", "sign", "bricks", "fill", "rest", "store floor",
                      "evaluation floor", "of the floor", "coarse pairs", "brick pairs", "evaluations per sample",
                      "within polyhedra", "max error, voxel"});
    result["rows"] = Json::array();
    for_each_workload(options, meshes, device, [&](const Workload& workload) {
        const Stages stages = measure_stages(workload, device, floors, options.measure);
        table.add(row_of(stages, workload));
        Json row = ::describe(workload);
        row.update(describe(stages, workload));
        result["rows"].push_back(std::move(row));
    });
    options.say('\n' + table.text());
    return result;
}

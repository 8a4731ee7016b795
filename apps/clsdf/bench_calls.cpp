#include "bench.hpp"

#include "benchmarks/calls.hpp"
#include "benchmarks/fractions.hpp"
#include "benchmarks/links.hpp"
#include "benchmarks/memory.hpp"
#include "benchmarks/points.hpp"
#include "benchmarks/rays.hpp"

#include <clsdf/io.hpp>

#include <fmt/format.h>

using clsdf::bench::CallCost;
using clsdf::bench::FractionCost;
using clsdf::bench::PointCost;
using clsdf::bench::RayCost;
using clsdf::bench::RestrictedMemory;

// The benchmarks of calls beside the whole one: of a time step, of points, and of a part of the domain.

namespace {

Json describe(const clsdf::bench::Spread& spread) {
    return {{"least", spread.least}, {"median", spread.median}, {"most", spread.most}};
}

Json describe(const CallCost& cost, const std::string& mesh) {
    Json row{{"name", cost.name},
             {"mesh", mesh},
             {"what", cost.what},
             {"ratio", cost.ratio},
             {"limit", nullptr},
             {"seconds", describe(cost.seconds)},
             {"base_seconds", describe(cost.base_seconds)},
             {"samples_judged", cost.judged},
             {"wrong", cost.wrong},
             {"max_error_voxels", cost.max_error_voxels}};
    if (cost.limit) row["limit"] = *cost.limit;
    return row;
}

}  // namespace

Json run_bench_calls(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    const clsdf::Device device = options.open_device();
    Json result = describe_run("calls", options, device);
    result["rows"] = Json::array();
    BenchTable table({"calls", "mesh", "ms (median)", "of, ms", "ratio", "limit", "wrong", "max error, voxel"});
    for (const NamedMesh& mesh : meshes)
        for (const CallCost& cost : measure_calls(mesh.mesh, device, options.measure, options.quick)) {
            table.add({cost.name, mesh.name, milliseconds(cost.seconds.median), milliseconds(cost.base_seconds.median),
                       fmt::format("{:.3g}", cost.ratio), cost.limit ? fmt::format("{:.3g}", *cost.limit) : "-",
                       fmt::format("{} of {}", cost.wrong, cost.judged), fmt::format("{:.2g}", cost.max_error_voxels)});
            result["rows"].push_back(describe(cost, mesh.name));
        }
    options.say('\n' + table.text());
    return result;
}

namespace {

Json describe(const PointCost& cost, const std::string& mesh) {
    Json row{{"name", cost.name},
             {"method", cost.method},
             {"mesh", mesh},
             {"what", cost.what},
             {"points", cost.points},
             {"calls", cost.calls},
             {"seconds", describe(cost.seconds)},
             {"processor_seconds", describe(cost.processor_seconds)},
             {"points_per_second", cost.points_per_second()},
             {"judged", cost.judged},
             {"wrong", cost.wrong},
             {"wrong_signs", cost.wrong_signs},
             {"max_error_voxels", cost.max_error_voxels}};
    if (cost.limit) row["limit"] = *cost.limit;
    return row;
}

}  // namespace

Json run_bench_points(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    const clsdf::Device device = options.open_device();
    Json result = describe_run("points", options, device);
    result["rows"] = Json::array();
    std::vector<clsdf::Vec3> points;
    if (!options.points.empty()) points = clsdf::read_points(options.points);
    if (!options.points.empty() && points.empty())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("{} has no points to measure with", options.points));
    BenchTable table({"points", "method", "mesh", "points", "calls", "ms (median)", "processor, ms", "million a second",
                      "limit", "wrong", "wrong signs", "judged", "max error, voxel"});
    for (const NamedMesh& mesh : meshes)
        for (const PointCost& cost : options.points.empty()
                                         ? measure_points(mesh.mesh, device, options.measure, options.quick)
                                         : measure_these_points(mesh.mesh, points, device, options.measure)) {
            table.add({cost.name, cost.method, mesh.name, fmt::format("{}", cost.points), fmt::format("{}", cost.calls),
                       milliseconds(cost.seconds.median), milliseconds(cost.processor_seconds.median),
                       fmt::format("{:.3g}", 1e-6 * cost.points_per_second()),
                       cost.limit ? fmt::format("{:.3g}", 1e-6 * *cost.limit) : "-", fmt::format("{}", cost.wrong),
                       fmt::format("{}", cost.wrong_signs), fmt::format("{}", cost.judged),
                       fmt::format("{:.2g}", cost.max_error_voxels)});
            result["rows"].push_back(describe(cost, mesh.name));
        }
    options.say('\n' + table.text());
    return result;
}

namespace {

/// What rays and links have in common: the table and the rows of their costs.
class RayRows {
public:
    RayRows(const char* name, const BenchOptions& options, const clsdf::Device& device)
        : name_(name),
          options_(options),
          result_(describe_run(name, options, device)),
          table_({name, "method", "mesh", "number", "ms (median)", "processor, ms", "million a second", "limit, ms",
                  "wrong", "judged", "max error, voxel"}) {
        result_["rows"] = Json::array();
    }

    void add(const RayCost& cost, const std::string& mesh) {
        table_.add({cost.name, cost.method, mesh, fmt::format("{}", cost.rays), milliseconds(cost.seconds.median),
                    milliseconds(cost.processor_seconds.median), fmt::format("{:.3g}", 1e-6 * cost.rays_per_second()),
                    cost.limit ? milliseconds(*cost.limit) : "-", fmt::format("{}", cost.wrong),
                    fmt::format("{}", cost.judged), fmt::format("{:.2g}", cost.max_error_voxels)});
        Json row{{name_, cost.name},
                 {"what", cost.what},
                 {"method", cost.method},
                 {"mesh", mesh},
                 {"count", cost.rays},
                 {"seconds", cost.seconds.median},
                 {"processor_seconds", cost.processor_seconds.median},
                 {std::string(name_) + "_per_second", cost.rays_per_second()},
                 {"wrong", cost.wrong},
                 {"judged", cost.judged},
                 {"max_error_voxels", cost.max_error_voxels}};
        if (cost.limit) row["limit_seconds"] = *cost.limit;
        result_["rows"].push_back(std::move(row));
    }

    Json finish() {
        options_.say('\n' + table_.text());
        return std::move(result_);
    }

private:
    const char* name_;
    const BenchOptions& options_;
    Json result_;
    BenchTable table_;
};

}  // namespace

Json run_bench_rays(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    const clsdf::Device device = options.open_device();
    RayRows rows("rays", options, device);
    for (const NamedMesh& mesh : meshes)
        for (const RayCost& cost : measure_rays(mesh.mesh, device, options.measure, options.quick))
            rows.add(cost, mesh.name);
    return rows.finish();
}

Json run_bench_links(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    const clsdf::Device device = options.open_device();
    RayRows rows("links", options, device);
    for (const NamedMesh& mesh : meshes)
        for (RayCost& cost : measure_links(mesh.mesh, device, options.measure, options.scaled(256))) {
            // The bars of the bunny.
            if (mesh.name == "bunny00" && !options.quick && cost.name == "first") cost.limit = 0.11;
            if (mesh.name == "bunny00" && !options.quick && cost.name == "again") cost.limit = 0.08;
            rows.add(cost, mesh.name);
        }
    for (const RayCost& cost : clsdf::bench::measure_links_of_ties(device, options.measure, options.scaled(256)))
        rows.add(cost, "-");
    return rows.finish();
}

Json run_bench_fractions(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    Json result = describe_run("fractions", options, options.open_device());
    result["rows"] = Json::array();
    BenchTable table({"cells", "mesh", "cut", "ms (median)", "processor, ms", "limit, ms", "error of the volume",
                      "error of the area"});
    for (const NamedMesh& mesh : meshes)
        for (FractionCost& cost :
             measure_fractions(mesh.mesh, options.measure, {options.scaled(128), options.scaled(256)})) {
            // The bars of the bunny on two cores.
            if (mesh.name == "bunny00" && cost.name == "128") cost.limit = 0.15;
            if (mesh.name == "bunny00" && cost.name == "256") cost.limit = 0.6;
            const auto error = [&](double value) { return cost.cells > 0 ? fmt::format("{:.1e}", value) : "-"; };
            table.add({cost.name, mesh.name, fmt::format("{}", cost.cells), milliseconds(cost.seconds.median),
                       milliseconds(cost.processor_seconds.median), cost.limit ? milliseconds(*cost.limit) : "-",
                       error(cost.volume_error), error(cost.area_error)});
            Json row{{"name", cost.name},
                     {"what", cost.what},
                     {"mesh", mesh.name},
                     {"cut_cells", cost.cells},
                     {"seconds", describe(cost.seconds)},
                     {"processor_seconds", describe(cost.processor_seconds)},
                     {"volume_error", cost.volume_error},
                     {"area_error", cost.area_error}};
            if (cost.limit) row["limit_seconds"] = *cost.limit;
            result["rows"].push_back(std::move(row));
        }
    options.say('\n' + table.text());
    return result;
}

Json run_bench_memory(const BenchOptions& options) {
    const std::vector<std::string> names = options.names_of_meshes({options.quick ? "sphere5" : "sphere9"});
    const clsdf::Device device = options.open_device();
    Json result = describe_run("memory", options, device);
    result["rows"] = Json::array();
    BenchTable table({"mesh", "triangles", "whole, MB", "an eighth, MB", "share", "without a mesh, MB",
                      "share beside that", "share of memory()", "samples", "different"});
    for (const std::string& name : names) {
        const auto load = [&] { return clsdf::bench::load_mesh(name, options.folder, options.measure.seed); };
        const RestrictedMemory memory = clsdf::bench::measure_restricted_memory(load, device, options.scaled(256));
        const auto megabytes = [](std::size_t bytes) {
            return fmt::format("{:.1f}", 1e-6 * static_cast<double>(bytes));
        };
        table.add({clsdf::bench::short_name(name), fmt::format("{}", memory.triangles), megabytes(memory.whole),
                   megabytes(memory.restricted), fmt::format("{:.3f}", memory.share()), megabytes(memory.without_mesh),
                   fmt::format("{:.3f}", memory.share_without_mesh()), fmt::format("{:.3f}", memory.kept_share()),
                   fmt::format("{}", memory.samples), fmt::format("{}", memory.different)});
        result["rows"].push_back({{"mesh", clsdf::bench::short_name(name)},
                                  {"triangles", memory.triangles},
                                  {"whole_bytes", memory.whole},
                                  {"restricted_bytes", memory.restricted},
                                  {"share", memory.share()},
                                  {"without_mesh_bytes", memory.without_mesh},
                                  {"share_without_mesh", memory.share_without_mesh()},
                                  {"kept_share", memory.kept_share()},
                                  {"samples", memory.samples},
                                  {"different", memory.different}});
    }
    options.say('\n' + table.text());
    return result;
}

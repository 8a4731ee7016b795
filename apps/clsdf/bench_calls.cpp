#include "bench.hpp"

#include "benchmarks/calls.hpp"
#include "benchmarks/points.hpp"

#include <fmt/format.h>

using clsdf::bench::CallCost;
using clsdf::bench::PointCost;
using nlohmann::ordered_json;

// The benchmarks of calls beside the whole one: of a time step, and of points.

namespace {

ordered_json describe(const clsdf::bench::Spread& spread) {
    return {{"least", spread.least}, {"median", spread.median}, {"most", spread.most}};
}

ordered_json describe(const CallCost& cost, const std::string& mesh) {
    ordered_json row{{"name", cost.name},
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

ordered_json run_bench_calls(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    const clsdf::Device device = options.open_device();
    ordered_json result = describe_run("calls", options, device);
    result["rows"] = ordered_json::array();
    BenchTable table({"calls", "mesh", "ms (median)", "of, ms", "ratio", "limit", "wrong", "max error, voxel"});
    for (const NamedMesh& mesh : meshes)
        for (const CallCost& cost : measure_calls(mesh.mesh, device, options.measure, options.quick)) {
            table.add({cost.name, mesh.name, milliseconds(cost.seconds.median), milliseconds(cost.base_seconds.median),
                       fmt::format("{:.3g}", cost.ratio), cost.limit ? fmt::format("{:.3g}", *cost.limit) : "-",
                       fmt::format("{} of {}", cost.wrong, cost.judged), fmt::format("{:.2g}", cost.max_error_voxels)});
            result["rows"].push_back(describe(cost, mesh.name));
        }
    options.say("\n" + table.text());
    return result;
}

namespace {

ordered_json describe(const PointCost& cost, const std::string& mesh) {
    ordered_json row{{"name", cost.name},
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

ordered_json run_bench_points(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes =
        options.load_meshes({options.quick ? std::string("sphere4") : std::string("bunny00")});
    const clsdf::Device device = options.open_device();
    ordered_json result = describe_run("points", options, device);
    result["rows"] = ordered_json::array();
    BenchTable table({"points", "method", "mesh", "points", "calls", "ms (median)", "processor, ms", "million a second",
                      "limit", "wrong", "wrong signs", "judged", "max error, voxel"});
    for (const NamedMesh& mesh : meshes)
        for (const PointCost& cost : measure_points(mesh.mesh, device, options.measure, options.quick)) {
            table.add({cost.name, cost.method, mesh.name, fmt::format("{}", cost.points), fmt::format("{}", cost.calls),
                       milliseconds(cost.seconds.median), milliseconds(cost.processor_seconds.median),
                       fmt::format("{:.3g}", 1e-6 * cost.points_per_second()),
                       cost.limit ? fmt::format("{:.3g}", 1e-6 * *cost.limit) : "-", fmt::format("{}", cost.wrong),
                       fmt::format("{}", cost.wrong_signs), fmt::format("{}", cost.judged),
                       fmt::format("{:.2g}", cost.max_error_voxels)});
            result["rows"].push_back(describe(cost, mesh.name));
        }
    options.say("\n" + table.text());
    return result;
}

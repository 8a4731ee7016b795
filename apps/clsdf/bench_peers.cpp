#include "bench.hpp"
#include "output.hpp"

#include "benchmarks/method.hpp"

#include <fmt/format.h>

#include <algorithm>

using clsdf::bench::Entry;
using clsdf::bench::Layout;
using clsdf::bench::Measurement;
using clsdf::bench::split_triangles;
using clsdf::bench::Workload;
using nlohmann::ordered_json;

namespace {

bool is_asked_for(const std::vector<std::string>& names, const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

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

std::vector<std::string> meshes_of(const BenchOptions& options) {
    if (!options.meshes.empty()) return options.meshes;
    return options.quick ? std::vector<std::string>{"sphere4"} : clsdf::bench::standard_meshes();
}

/// W4 is a job of triangles far smaller than voxels: the mesh split twice, of the first mesh only unless it is asked
/// for.
bool is_due(const Layout& layout, const BenchOptions& options, const std::string& mesh) {
    if (!is_asked_for(options.workloads, layout.name)) return false;
    return layout.name != "W4" || !options.workloads.empty() || mesh == meshes_of(options).front();
}

ordered_json describe(const Entry& entry) {
    return {
        {"name", entry.name}, {"version", entry.version}, {"there", entry.method != nullptr}, {"remedy", entry.remedy}};
}

}  // namespace

ordered_json run_bench_peers(const BenchOptions& options) {
    const clsdf::Device device = options.open_device();
    const std::vector<Entry> entries = clsdf::bench::all_methods(device);
    std::vector<clsdf::bench::Method*> methods;
    ordered_json result = describe_run("peers", options, device);
    result["methods"] = ordered_json::array();
    for (const Entry& entry : entries) {
        if (!is_asked_for(options.methods, entry.name)) continue;
        result["methods"].push_back(describe(entry));
        if (entry.method)
            methods.push_back(entry.method.get());
        else
            options.say(fmt::format("{}: {}", entry.name, entry.remedy));
    }
    result["rows"] = ordered_json::array();
    for (const std::string& name : meshes_of(options)) {
        const std::optional<clsdf::Mesh> mesh = options.mesh(name);
        if (!mesh) continue;
        for (const Layout& layout : clsdf::bench::standard_layouts()) {
            if (!is_due(layout, options, name)) continue;
            const Workload workload =
                make_workload(options.scaled(layout), clsdf::bench::short_name(name),
                              layout.name == "W4" ? split_triangles(split_triangles(*mesh)) : *mesh, device);
            const std::vector<Measurement> measurements = measure_in_turns(workload, methods, options.measure);
            options.say(fmt::format("\n{}\n\n{}", title_of(workload), table_of(measurements)));
            for (const Measurement& measurement : measurements) {
                ordered_json row = ::describe(workload);
                row.update(::describe(measurement));
                result["rows"].push_back(std::move(row));
            }
        }
    }
    return result;
}

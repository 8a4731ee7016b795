#include "bench.hpp"
#include "output.hpp"

#include "benchmarks/method.hpp"

#include <fmt/format.h>

using clsdf::bench::Entry;
using clsdf::bench::Measurement;
using clsdf::bench::Workload;
using nlohmann::ordered_json;

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

ordered_json describe(const Entry& entry) {
    return {
        {"name", entry.name}, {"version", entry.version}, {"there", entry.method != nullptr}, {"remedy", entry.remedy}};
}

}  // namespace

ordered_json run_bench_peers(const BenchOptions& options) {
    const std::vector<NamedMesh> meshes = load_standard_meshes(options);
    const clsdf::Device device = options.open_device();
    const std::vector<Entry> entries = clsdf::bench::all_methods(device);
    const std::vector<clsdf::bench::Method*> methods = options.choose(entries);
    ordered_json result = describe_run("peers", options, device);
    result["methods"] = ordered_json::array();
    for (const Entry& entry : entries)
        if (options.methods.empty() || contains(options.methods, entry.name))
            result["methods"].push_back(describe(entry));
    result["rows"] = ordered_json::array();
    for_each_workload(options, meshes, device, [&](const Workload& workload) {
        const std::vector<Measurement> measurements = measure_in_turns(workload, methods, options.measure);
        options.say(fmt::format("\n{}\n\n{}", title_of(workload), table_of(measurements)));
        for (const Measurement& measurement : measurements) {
            ordered_json row = ::describe(workload);
            row.update(::describe(measurement));
            result["rows"].push_back(std::move(row));
        }
    });
    return result;
}

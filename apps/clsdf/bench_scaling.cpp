#include "bench.hpp"
#include "output.hpp"

#include "benchmarks/machine.hpp"
#include "benchmarks/method.hpp"

#include <fmt/format.h>

#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <thread>

using clsdf::Length;
using clsdf::bench::Entry;
using clsdf::bench::Layout;
using clsdf::bench::Measurement;
using clsdf::bench::Workload;
using nlohmann::ordered_json;

namespace {

/// A point of a series: what is varied, and the job at that value.
struct Point {
    std::string series;
    double value;
    std::string mesh;
    Layout layout;
};

std::string mesh_of(const BenchOptions& options) {
    if (!options.meshes.empty()) return options.meshes.front();
    return options.quick ? "sphere4" : "bunny00";
}

std::vector<Point> points_of(const std::string& series, const BenchOptions& options) {
    const std::int64_t resolution = options.quick ? 32 : 256;
    const Length usual = Length::of_extent(0.1);
    std::vector<Point> points;
    const auto add = [&](double value, const std::string& mesh, std::int64_t samples, Length half_width) {
        points.push_back({series, value, mesh, {fmt::format("{} = {:g}", series, value), samples, half_width}});
    };
    if (series == "N")
        for (const std::int64_t n : {resolution / 4, resolution / 2, resolution, resolution * 3 / 2, resolution * 2})
            add(static_cast<double>(n), mesh_of(options), n, usual);
    if (series == "d")
        for (const double percent : {1.0, 2.0, 5.0, 10.0, 20.0, 40.0})
            add(percent, mesh_of(options), resolution, Length::of_extent(percent / 100));
    if (series == "triangles")
        for (int level = 2; level <= (options.quick ? 4 : 8); ++level)
            add(8.0 * std::pow(4.0, level), fmt::format("sphere{}", level), resolution, usual);
    if (series == "threads") add(static_cast<double>(options.threads), mesh_of(options), resolution, usual);
    return points;
}

/// What a run of this very program prints on standard output.
std::string output_of(std::vector<std::string> arguments) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw clsdf::Error(clsdf::ErrorCode::out_of_memory, "no pipe for a run of one thread");
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        close(ends[1]);
        arguments.insert(arguments.begin(), "clsdf");
        std::vector<char*> words;
        for (std::string& argument : arguments) words.push_back(argument.data());
        words.push_back(nullptr);
        execv("/proc/self/exe", words.data());
        _exit(127);
    }
    close(ends[1]);
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t count = 0; (count = read(ends[0], part.data(), part.size())) > 0;)
        text.append(part.data(), static_cast<std::size_t>(count));
    close(ends[0]);
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child || status != 0)
        throw clsdf::Error(clsdf::ErrorCode::unsupported,
                           "the run with another number of threads failed; what it printed above says why");
    return text;
}

/// OpenCL and the host's loops take their number of threads once in a process: each number has a process of its own.
ordered_json rows_of_threads(const BenchOptions& options) {
    std::vector<std::size_t> counts;
    const std::size_t all = std::max(1U, std::thread::hardware_concurrency());
    for (std::size_t count = 1; count < all; count *= 2) counts.push_back(count);
    counts.push_back(all);
    ordered_json rows = ordered_json::array();
    for (const std::size_t count : counts) {
        std::vector<std::string> arguments{"bench",
                                           "scaling",
                                           mesh_of(options),
                                           "--series",
                                           "threads",
                                           "--threads",
                                           std::to_string(count),
                                           "--json",
                                           "--quiet",
                                           "--meshes",
                                           options.folder,
                                           "--repetitions",
                                           std::to_string(options.measure.repetitions),
                                           "--seed",
                                           std::to_string(options.measure.seed)};
        if (options.quick) arguments.emplace_back("--quick");
        if (!options.methods.empty())
            arguments.insert(arguments.end(), {"--method", fmt::format("{}", fmt::join(options.methods, ","))});
        if (!options.device.empty()) arguments.insert(arguments.end(), {"--device", options.device});
        const ordered_json result = ordered_json::parse(output_of(std::move(arguments)));
        for (const ordered_json& row : result["rows"]) rows.push_back(row);
    }
    return rows;
}

ordered_json rows_here(const std::string& series, const BenchOptions& options, const clsdf::Device& device,
                       const std::vector<clsdf::bench::Method*>& methods) {
    ordered_json rows = ordered_json::array();
    for (const Point& point : points_of(series, options)) {
        const std::optional<clsdf::Mesh> mesh = options.mesh(point.mesh);
        if (!mesh) continue;
        const Workload workload = make_workload(point.layout, clsdf::bench::short_name(point.mesh), *mesh, device);
        for (const Measurement& measurement : measure_in_turns(workload, methods, options.measure)) {
            ordered_json row{{"series", point.series}, {"value", point.value}};
            row.update(describe(workload));
            row.update(describe(measurement));
            rows.push_back(std::move(row));
        }
    }
    return rows;
}

std::string table_of(const ordered_json& rows) {
    BenchTable table({"series", "value", "mesh", "method", "with their distance", "least, ms", "median", "most",
                      "million samples/s", "max error, voxel", "wrong", "judged"});
    for (const ordered_json& row : rows) {
        const ordered_json &wall = row["wall_seconds"], &judged = row["judgement"];
        const std::size_t wrong = judged["wrong_values"].get<std::size_t>() + judged["wrong_signs"].get<std::size_t>() +
                                  judged["missed"].get<std::size_t>() + judged["leaked"].get<std::size_t>();
        const double median = wall["median"].get<double>();
        table.add({row["series"].get<std::string>(), fmt::format("{:g}", row["value"].get<double>()),
                   row["mesh"].get<std::string>(), row["method"].get<std::string>(),
                   std::to_string(row["band_samples"].get<std::size_t>()), milliseconds(wall["least"].get<double>()),
                   milliseconds(median), milliseconds(wall["most"].get<double>()),
                   fmt::format("{:.1f}", row["band_samples"].get<double>() / median / 1e6),
                   fmt::format("{:.2g}", judged["max_error_voxels"].get<double>()), std::to_string(wrong),
                   std::to_string(judged["samples"].get<std::size_t>())});
    }
    return table.text();
}

}  // namespace

ordered_json run_bench_scaling(const BenchOptions& options) {
    const std::vector<std::string> series =
        options.series.empty() ? std::vector<std::string>{"threads", "N", "d", "triangles"} : options.series;
    // First, while this process has not touched OpenCL.
    ordered_json rows = ordered_json::array();
    const bool threads_elsewhere = options.threads == 0;
    if (threads_elsewhere && std::find(series.begin(), series.end(), "threads") != series.end())
        rows = rows_of_threads(options);

    const clsdf::Device device = options.open_device();
    const std::vector<Entry> entries = clsdf::bench::all_methods(device);
    const std::vector<std::string> asked =
        options.methods.empty() ? std::vector<std::string>{"clsdf"} : options.methods;
    std::vector<clsdf::bench::Method*> methods;
    for (const Entry& entry : entries)
        if (entry.method && std::find(asked.begin(), asked.end(), entry.name) != asked.end())
            methods.push_back(entry.method.get());
    for (const std::string& one : series)
        if (one != "threads" || !threads_elsewhere)
            for (ordered_json& row : rows_here(one, options, device, methods)) rows.push_back(std::move(row));

    options.say(table_of(rows));
    ordered_json result = describe_run("scaling", options, device);
    result["rows"] = rows;
    return result;
}

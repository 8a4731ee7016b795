#include "bench.hpp"
#include "report.hpp"

#include "benchmarks/machine.hpp"
#include "benchmarks/method.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

namespace {

/// A point of a series: what is varied, and the job at that value.
struct Point {
    std::string series;
    double value;
    NamedMesh mesh;
    Layout layout;
};

/// The mesh of all series but that over triangles; nothing if it is the default mesh and missing.
std::optional<NamedMesh> load_mesh(const BenchOptions& options) {
    if (options.meshes.size() > 1)
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("bench scaling takes one mesh, not also '{}'", options.meshes[1]));
    std::vector<NamedMesh> loaded = options.load_meshes({options.quick ? "sphere4" : "bunny00"});
    return loaded.empty() ? std::nullopt : std::optional(std::move(loaded.front()));
}

std::vector<Point> points_of(const std::string& series, const std::optional<NamedMesh>& mesh,
                             const BenchOptions& options) {
    const std::int64_t resolution = options.scaled(256);
    const Length usual = Length::of_extent(0.1);
    std::vector<Point> points;
    const auto add = [&](double value, const NamedMesh& of, std::int64_t samples, Length half_width) {
        points.push_back({series, value, of, {fmt::format("{} = {:g}", series, value), samples, half_width}});
    };
    if (series == "triangles")
        for (int level = 2; level <= (options.quick ? 4 : 9); ++level) {
            const std::string name = fmt::format("sphere{}", level);
            const clsdf::Mesh sphere = clsdf::make_shape(name);
            add(static_cast<double>(sphere.triangles().size()), {name, sphere}, resolution, usual);
        }
    if (!mesh) return points;
    if (series == "N")
        for (const std::int64_t n : {resolution / 4, resolution / 2, resolution, resolution * 3 / 2, resolution * 2})
            add(static_cast<double>(n), *mesh, n, usual);
    if (series == "d")
        for (const double percent : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 100.0})
            add(percent, *mesh, resolution, Length::of_extent(percent / 100));
    if (series == "threads") add(static_cast<double>(options.threads.value_or(0)), *mesh, resolution, usual);
    return points;
}

/// The standard output of a run of this program.
std::string output_of(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "clsdf");
    std::vector<char*> words;
    words.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw clsdf::Error(clsdf::ErrorCode::out_of_memory, "no pipe for a run of one thread");
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        close(ends[1]);
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
        throw clsdf::Error(clsdf::ErrorCode::device_failure,
                           "the run with another number of threads failed; its output above has the reason");
    return text;
}

/// OpenCL and the host's loops set their number of threads once in a process, so each number is measured in a new
/// process.
Json rows_of_threads(const BenchOptions& options) {
    std::vector<std::size_t> counts;
    const std::size_t all = std::max(1U, std::thread::hardware_concurrency());
    for (std::size_t count = 1; count < all; count *= 2) counts.push_back(count);
    counts.push_back(all);
    Json rows = Json::array();
    for (const std::size_t count : counts) {
        std::vector<std::string> arguments{"bench",
                                           "scaling",
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
                                           "--seconds-per-call",
                                           fmt::format("{}", options.measure.seconds_per_call),
                                           "--samples",
                                           std::to_string(options.measure.samples_judged),
                                           "--seed",
                                           std::to_string(options.measure.seed)};
        if (!options.meshes.empty()) arguments.push_back(options.meshes.front());
        if (options.quick) arguments.emplace_back("--quick");
        const auto add = [&arguments](const char* option, std::string value) {
            arguments.emplace_back(option);
            arguments.push_back(std::move(value));
        };
        if (!options.methods.empty()) add("--method", fmt::format("{}", fmt::join(options.methods, ",")));
        if (!options.device.empty()) add("--device", options.device);
        const Json result = Json::parse(output_of(std::move(arguments)));
        for (const Json& row : result["rows"].elements()) rows.push_back(row);
    }
    return rows;
}

Json rows_here(const std::string& series, const std::optional<NamedMesh>& mesh, const BenchOptions& options,
               const clsdf::Device& device, const std::vector<clsdf::bench::Method*>& methods) {
    Json rows = Json::array();
    for (const Point& point : points_of(series, mesh, options)) {
        const Workload workload = make_workload(point.layout, point.mesh.name, point.mesh.mesh, device);
        for (const Measurement& measurement : measure_in_turns(workload, methods, options.measure)) {
            Json row{{"series", point.series}, {"value", point.value}};
            row.update(describe(workload));
            row.update(describe(measurement));
            rows.push_back(std::move(row));
        }
    }
    return rows;
}

std::string table_of(const Json& rows) {
    BenchTable table({"series", "value", "mesh", "method", "with their distance", "least, ms", "median", "most",
                      "million samples/s", "max error, voxel", "wrong", "judged"});
    for (const Json& row : rows.elements()) {
        const Json &wall = row["wall_seconds"], &judged = row["judgement"];
        const double wrong = judged["wrong_values"].number() + judged["wrong_signs"].number() +
                             judged["missed"].number() + judged["leaked"].number();
        const double samples = row["band_samples"].number(), median = wall["median"].number();
        table.add({row["series"].text(), fmt::format("{:.8g}", row["value"].number()), row["mesh"].text(),
                   row["method"].text(), fmt::format("{:.0f}", samples), milliseconds(wall["least"].number()),
                   milliseconds(median), milliseconds(wall["most"].number()),
                   fmt::format("{:.1f}", samples / median / 1e6),
                   fmt::format("{:.2g}", judged["max_error_voxels"].number()), fmt::format("{:.0f}", wrong),
                   fmt::format("{:.0f}", judged["samples"].number())});
    }
    return table.text();
}

}  // namespace

Json run_bench_scaling(const BenchOptions& stated) {
    BenchOptions options = stated;
    if (options.methods.empty()) options.methods = {"clsdf"};
    const std::vector<std::string> series = options.series_of({"threads", "N", "d", "triangles"});
    const std::optional<NamedMesh> mesh = load_mesh(options);
    const clsdf::Device device = options.open_device();
    const std::vector<Entry> entries = clsdf::bench::all_methods(device);
    const std::vector<clsdf::bench::Method*> methods = options.choose(entries);

    Json rows = Json::array();
    for (const std::string& one : series) {
        const bool threads_elsewhere = one == "threads" && !options.threads;
        if (threads_elsewhere && !mesh) continue;
        const Json added =
            threads_elsewhere ? rows_of_threads(options) : rows_here(one, mesh, options, device, methods);
        for (const Json& row : added.elements()) rows.push_back(row);
    }
    options.say(table_of(rows));
    Json result = describe_run("scaling", options, device);
    result["rows"] = rows;
    return result;
}

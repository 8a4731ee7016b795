#pragma once

#include "json.hpp"

#include "benchmarks/measure.hpp"
#include "benchmarks/meshes.hpp"

#include <clsdf/clsdf.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

struct Report;

struct NamedMesh {
    std::string name;  ///< "bunny00"
    clsdf::Mesh mesh;
};

/// The options that the benchmarks share.
struct BenchOptions {
    std::string benchmark;
    std::vector<std::string> meshes;  ///< empty: those of the subcommand's own list
    std::string folder = "build/meshes";
    std::vector<std::string> workloads;
    std::vector<std::string> methods;
    std::vector<std::string> series;
    std::string points;  ///< empty: random ones
    clsdf::bench::MeasureOptions measure;
    std::optional<std::size_t> threads;  ///< otherwise all
    std::string device;
    std::string commit;
    bool quick = false;
    bool quiet = false;
    Report* report = nullptr;  ///< for warnings

    clsdf::Device open_device() const;

    /// The meshes that were named, or those of the subcommand's own list. A missing mesh of the list is skipped with a
    /// message. All are loaded before the first measurement, so that an error costs no time.
    std::vector<NamedMesh> load_meshes(const std::vector<std::string>& own_list) const;

    /// The names of these meshes, checked, for a benchmark that loads them itself.
    std::vector<std::string> names_of_meshes(const std::vector<std::string>& own_list) const;

    /// The methods that were named, or all that are built in. Throws Error(unsupported) if a named one is not built in.
    std::vector<clsdf::bench::Method*> choose(const std::vector<clsdf::bench::Entry>& entries) const;

    /// The series that were named, or all that the benchmark has. Throws Error(invalid_argument) for others.
    std::vector<std::string> series_of(const std::vector<std::string>& known) const;

    /// With --quick, an eighth of the samples on a side.
    std::int64_t scaled(std::int64_t resolution) const;

    /// A line on standard error, unless --quiet.
    void say(const std::string& line) const;
};

bool contains(const std::vector<std::string>& words, const std::string& word);

// The standard jobs of the standard meshes, for peers and floors.
std::vector<NamedMesh> load_standard_meshes(const BenchOptions& options);
void for_each_workload(const BenchOptions& options, const std::vector<NamedMesh>& meshes, const clsdf::Device& device,
                       const std::function<void(const clsdf::bench::Workload&)>& measure);

/// A table on standard error, in Markdown, its columns aligned; numbers to the right.
class BenchTable {
public:
    explicit BenchTable(std::vector<std::string> header) : rows_{std::move(header)} {}
    void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
    std::string text() const;

private:
    std::vector<std::vector<std::string>> rows_;
};

/// The description of a run that every result has: benchmark, version, machine, device and date.
Json describe_run(const char* benchmark, const BenchOptions& options, const clsdf::Device& device);
Json describe(const clsdf::bench::Workload& workload);
Json describe(const clsdf::bench::Judgement& judgement);
Json describe(const clsdf::bench::Measurement& measurement);

/// "12.3", in milliseconds, with three digits at least.
std::string milliseconds(double seconds);
/// The cells of a judgement: the error, then the counts of wrong values, wrong signs, missed and leaked samples.
std::vector<std::string> cells_of(const clsdf::bench::Judgement& judgement);
std::string title_of(const clsdf::bench::Workload& workload);

// The benchmarks; each prints its table, and returns what --json prints.
Json run_bench_peers(const BenchOptions& options);
Json run_bench_scaling(const BenchOptions& stated);
Json run_bench_floors(const BenchOptions& options);
Json run_bench_papers(const BenchOptions& options);
Json run_bench_calls(const BenchOptions& options);
Json run_bench_points(const BenchOptions& options);
Json run_bench_rays(const BenchOptions& options);
Json run_bench_links(const BenchOptions& options);
Json run_bench_fractions(const BenchOptions& options);
Json run_bench_memory(const BenchOptions& options);

#include "bench.hpp"

#include "benchmarks/machine.hpp"
#include "command.hpp"
#include "devices.hpp"
#include "nearest_word.hpp"
#include "report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>

using clsdf::bench::Judgement;
using clsdf::bench::Measurement;
using clsdf::bench::Workload;

std::string BenchTable::text() const {
    const std::size_t columns = rows_.front().size();
    std::vector<std::size_t> widths(columns, 3);
    for (const auto& row : rows_)
        for (std::size_t c = 0; c < columns; ++c) widths[c] = std::max(widths[c], row[c].size());
    // A column is numeric if its cells start with a digit.
    const auto is_number = [&](std::size_t c) {
        return rows_.size() > 1 && std::all_of(rows_.begin() + 1, rows_.end(), [&](const auto& row) {
                   return row[c].empty() || row[c] == "-" || (row[c][0] >= '0' && row[c][0] <= '9');
               });
    };
    std::string text;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
        for (std::size_t c = 0; c < columns; ++c)
            text += is_number(c) ? fmt::format("| {:>{}} ", rows_[r][c], widths[c])
                                 : fmt::format("| {:<{}} ", rows_[r][c], widths[c]);
        text += "|\n";
        if (r > 0) continue;
        for (std::size_t c = 0; c < columns; ++c)
            text += fmt::format("|{:-<{}}{}", "", widths[c] + 1, is_number(c) ? ':' : '-');
        text += "|\n";
    }
    return text;
}

Json describe_run(const char* benchmark, const BenchOptions& options, const clsdf::Device& device) {
    const clsdf::bench::Machine machine = clsdf::bench::this_machine(options.threads.value_or(0));
    return {{"benchmark", benchmark},
            {"version", clsdf::version()},
            {"commit", options.commit},
            {"date", clsdf::bench::time_of_day()},
            {"machine",
             {{"processor", machine.processor},
              {"threads", machine.threads},
              {"memory_bytes", machine.memory_bytes},
              {"system", machine.system}}},
            {"device", {{"name", device.name()}, {"platform", device.platform()}}},
            {"quick", options.quick},
            {"repetitions", options.measure.repetitions},
            {"seed", options.measure.seed}};
}

Json describe(const Workload& workload) {
    return {{"workload", workload.name},
            {"mesh", workload.mesh_name},
            {"triangles", workload.mesh.triangles().size()},
            {"mean_area_voxels", clsdf::bench::mean_area_voxels(workload)},
            {"grid", describe(workload.grid)},
            {"half_width_voxels", workload.band.outside / workload.grid.voxel()},
            {"sign", name_of(workload.sign)},
            {"band_samples", workload.list.samples.size()}};
}

Json describe(const Judgement& judgement) {
    return {{"exact", judgement.exact()},
            {"samples", judgement.samples},
            {"max_error_voxels", judgement.max_error_voxels},
            {"mean_error_voxels", judgement.mean_error_voxels},
            {"wrong_values", judgement.wrong_values},
            {"wrong_signs", judgement.wrong_signs},
            {"missed", judgement.missed},
            {"leaked", judgement.leaked}};
}

Json describe(const Measurement& measurement) {
    const auto spread = [](const std::vector<double>& values) -> Json {
        const clsdf::bench::Spread s = clsdf::bench::spread_of(values);
        return {{"least", s.least}, {"median", s.median}, {"most", s.most}, {"each", values}};
    };
    return {{"method", measurement.method},
            {"note", measurement.note},
            {"stride", measurement.stride},
            {"wall_seconds", spread(measurement.wall)},
            {"processor_seconds", spread(measurement.processor)},
            {"peak_bytes", measurement.peak_bytes},
            {"judgement", describe(measurement.judgement)}};
}

std::string milliseconds(double seconds) {
    const double value = 1e3 * seconds;
    return value < 1     ? fmt::format("{:.3f}", value)
           : value < 100 ? fmt::format("{:.1f}", value)
                         : fmt::format("{:.0f}", value);
}

std::vector<std::string> cells_of(const Judgement& judgement) {
    return {fmt::format("{:.2g}", judgement.max_error_voxels),
            std::to_string(judgement.wrong_values),
            std::to_string(judgement.wrong_signs),
            std::to_string(judgement.missed),
            std::to_string(judgement.leaked),
            std::to_string(judgement.samples)};
}

std::string title_of(const Workload& workload) {
    const auto& size = workload.grid.size;
    const std::string band =
        std::isinf(workload.band.outside)
            ? "every sample"
            : fmt::format("half width {:.2f} voxels", workload.band.outside / workload.grid.voxel());
    return fmt::format(
        "{}, {}: {} triangles of {:.3g} voxels on average, {} x {} x {} samples, {}, {} with their distance",
        workload.name, workload.mesh_name, workload.mesh.triangles().size(), mean_area_voxels(workload), size[0],
        size[1], size[2], band, workload.list.samples.size());
}

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::bench::Entry;

namespace {

/// A word that is no file may be a mistyped name. A word with an ending or a folder goes to the reader, whose message
/// says more.
void check_name(const std::string& word) {
    const std::vector<std::string> known = clsdf::bench::mesh_names();
    std::error_code ignored;
    if (contains(known, word) || word.find_first_of("./") != std::string::npos ||
        std::filesystem::exists(word, ignored))
        return;
    throw Error(ErrorCode::invalid_argument,
                fmt::format("there is no mesh '{}'{}\nThe names are {}; any other mesh is a file.", word,
                            did_you_mean(nearest_word(word, known)), fmt::join(known, ", ")));
}

}  // namespace

bool contains(const std::vector<std::string>& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

clsdf::Device BenchOptions::open_device() const {
    return report == nullptr ? ::open_device(device) : ::open_device(device, *report);
}

std::vector<std::string> BenchOptions::names_of_meshes(const std::vector<std::string>& own_list) const {
    for (const std::string& name : meshes) check_name(name);
    return meshes.empty() ? own_list : meshes;
}

std::vector<NamedMesh> BenchOptions::load_meshes(const std::vector<std::string>& own_list) const {
    std::vector<NamedMesh> loaded;
    for (const std::string& name : names_of_meshes(own_list)) try {
            loaded.push_back({clsdf::bench::short_name(name), clsdf::bench::load_mesh(name, folder, measure.seed)});
        } catch (const Error& error) {
            if (!meshes.empty() || error.code() != ErrorCode::unreadable_input) throw;
            print_text("left out: {}\n", error.what());
        }
    return loaded;
}

std::vector<clsdf::bench::Method*> BenchOptions::choose(const std::vector<Entry>& entries) const {
    std::vector<clsdf::bench::Method*> chosen;
    for (const Entry& entry : entries) {
        if (!methods.empty() && !contains(methods, entry.name)) continue;
        if (entry.method)
            chosen.push_back(entry.method.get());
        else if (methods.empty())
            say(fmt::format("{}: {}", entry.name, entry.remedy));
        else
            throw Error(ErrorCode::unsupported, fmt::format("--method {}: {}", entry.name, entry.remedy));
    }
    return chosen;
}

std::vector<std::string> BenchOptions::series_of(const std::vector<std::string>& known) const {
    for (const std::string& name : series)
        if (!contains(known, name))
            throw Error(ErrorCode::invalid_argument, fmt::format("--series {} is no series of bench {}, which has {}",
                                                                 name, benchmark, fmt::join(known, ", ")));
    return series.empty() ? known : series;
}

std::int64_t BenchOptions::scaled(std::int64_t resolution) const {
    return quick ? resolution / 8 : resolution;
}

void BenchOptions::say(const std::string& line) const {
    if (!quiet) print_text("{}\n", line);
}

namespace {

const char* const examples =
    "Examples:\n"
    "  clsdf bench peers bunny00 --workload W1\n"
    "  clsdf bench peers dragon.off --workload W2 --method clsdf,embree\n"
    "  clsdf bench scaling --series N,d --json > scaling.json\n"
    "  clsdf bench floors --quick\n"
    "  clsdf bench papers sphere6";

struct Benchmark {
    std::string name;
    const char* what;
    Json (*run)(const BenchOptions&);
    std::vector<std::string> takes;  ///< the options that this benchmark takes, but not every one
};

const std::vector<Benchmark> benchmarks{
    {"peers",
     "the whole call beside the peers that are installed",
     run_bench_peers,
     {"--workload", "--method", "--seconds-per-call"}},
    {"scaling",
     "series in samples, width of the band, triangles and threads",
     run_bench_scaling,
     {"--method", "--series", "--seconds-per-call"}},
    {"floors", "the device's own limits, and each stage against them", run_bench_floors, {"--workload"}},
    {"papers", "the comparisons of the papers: polyhedra, scans, saddle vertices", run_bench_papers, {"--series"}},
    {"calls", "the calls of a time step: a grid again, one sample, patches, vertices that move", run_bench_calls, {}},
    {"points", "points anywhere: uniform, near the surface, along rays, in many calls", run_bench_points, {"--points"}},
    {"rays", "first faces of rays beside Embree's robust mode, first walls, numbers of faces", run_bench_rays, {}},
    {"links",
     "links of a lattice: a mesh first and again, and a cube on planes of the lattice beside a ball",
     run_bench_links,
     {}},
    {"fractions",
     "cut cells with and without the outer surface, and what their sums are off by",
     run_bench_fractions,
     {}},
    {"memory",
     "what a process holds for a mesh, whole and restricted to an eighth of the domain",
     run_bench_memory,
     {}}};

void check_options(const Benchmark& chosen, const Parser& parser) {
    for (const Benchmark& other : benchmarks)
        for (const std::string& option : other.takes)
            if (parser.has(option) && !contains(chosen.takes, option))
                throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                                   fmt::format("{} is no option of bench {}, which takes {}{} those of all benchmarks\n"
                                               "\"clsdf bench --help\" lists the options.",
                                               option, chosen.name, fmt::join(chosen.takes, ", "),
                                               chosen.takes.empty() ? "only" : " and"));
}

/// --quick does not override options of the command line.
void make_quick(const Parser& parser, BenchOptions& options) {
    if (!options.quick) return;
    if (!parser.has("--repetitions")) options.measure.repetitions = 2;
    if (!parser.has("--samples")) options.measure.samples_judged = 2000;
    if (!parser.has("--seconds-per-call")) options.measure.seconds_per_call = 0.5;
}

void show_progress(BenchOptions& options) {
    if (options.quiet || isatty(STDERR_FILENO) == 0) return;
    options.measure.progress = [](const std::string& method) { print_text("\r\033[K{} ...\r", method); };
}

}  // namespace

Command add_bench(Parser& program) {
    const auto options = std::make_shared<BenchOptions>();
    Parser parser = program.add_subcommand("bench", "Measure speed, and the errors of the fields that were timed");
    std::vector<std::string> names;
    names.reserve(benchmarks.size());
    for (const Benchmark& benchmark : benchmarks) names.push_back(benchmark.name);
    parser.add("BENCHMARK", options->benchmark, "the measurement").takes_one_of(names).required();
    parser.add("MESHES", options->meshes,
               "files, or names: bunny00, armadillo, fandisk_large, refined_elephant (from --meshes), "
               "noisy_sphere, and those of \"clsdf shape\"");
    parser.add("--meshes", options->folder, "the folder of the meshes of scripts/fetch-meshes").takes("FOLDER");
    parser.add("--workload", options->workloads, "of peers and floors, separated by commas [all; W4 of the first mesh]")
        .takes_some_of({"W1", "W2", "W3", "W4"});
    parser.add("--method", options->methods, "of peers and scaling, separated by commas [peers: all, scaling: clsdf]")
        .takes_some_of({"clsdf", "again", "embree", "openvdb", "cgal"});
    parser
        .add("--series", options->series,
             "of scaling (N, d, triangles, threads) and papers (table-1, scans, far-field, under-sampled), separated "
             "by commas [all]")
        .takes_some_of({"N", "d", "triangles", "threads", "table-1", "scans", "far-field", "under-sampled"});
    parser.add("--points", options->points, "of points: a file, .npy, .csv or .ply, for random ones").takes("FILE");
    parser.add("--repetitions", options->measure.repetitions, "timed calls of each method, after those that warm up")
        .takes_whole_number("N", 1, 10000);
    parser
        .add("--seconds-per-call", options->measure.seconds_per_call,
             "of peers and scaling: a method that is asked sample by sample computes only so many bricks that a call "
             "takes about this long; its row says so")
        .takes_number_of_0_or_more("S");
    parser.add("--samples", options->measure.samples_judged, "samples held against the reference; 0: all")
        .takes_whole_number("N", 0, 1'000'000'000);
    parser.add("--seed", options->measure.seed, "of those samples, and of the noisy sphere")
        .takes_whole_number("N", 0, std::numeric_limits<std::uint64_t>::max());
    add_device_option(parser, options->device, "what computes");
    parser.add("--threads", options->threads, "of the processor, for all methods [all]")
        .takes_whole_number("N", 1, 4096);
    parser.add("--commit", options->commit, "text that the record carries").takes("TEXT");
    parser.add("--quick", options->quick, "small grids and few calls: to see that it works, not to measure");
    std::string explanation;
    for (const Benchmark& benchmark : benchmarks)
        explanation += fmt::format("{}: {}.\n", benchmark.name, benchmark.what);
    parser.set_footer(explanation + '\n' + examples);
    return {parser, [options, parser](Report& report) {
                const auto chosen = std::find_if(benchmarks.begin(), benchmarks.end(), [&](const Benchmark& benchmark) {
                    return benchmark.name == options->benchmark;
                });
                check_options(*chosen, parser);
                make_quick(parser, *options);
                options->quiet = report.quiet;
                options->report = &report;
                show_progress(*options);
                std::optional<clsdf::bench::ThreadLimit> limit;
                if (options->threads) limit.emplace(*options->threads);
                report.result = chosen->run(*options);
                return ExitStatus::done;
            }};
}

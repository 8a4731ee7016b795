#include "bench.hpp"
#include "command.hpp"
#include "devices.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include "benchmarks/machine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::bench::Entry;

namespace {

/// A word that is no file may be a mistyped name. A word with an ending or a folder goes to the reader, whose message
/// says more.
void check_name(const std::string& word) {
    const std::vector<std::string> known = clsdf::bench::mesh_names();
    if (contains(known, word) || word.find_first_of("./") != std::string::npos || std::filesystem::exists(word)) return;
    throw Error(ErrorCode::invalid_argument,
                fmt::format("there is no mesh '{}'{}\nThe names are {}; any other mesh is a file.", word,
                            did_you_mean(nearest_word(word, known)), fmt::join(known, ", ")));
}

}  // namespace

bool contains(const std::vector<std::string>& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

clsdf::Device BenchOptions::open_device() const {
    return ::open_device(device);
}

std::vector<NamedMesh> BenchOptions::load_meshes(const std::vector<std::string>& own_list) const {
    for (const std::string& name : meshes) check_name(name);
    std::vector<NamedMesh> loaded;
    for (const std::string& name : meshes.empty() ? own_list : meshes) try {
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
    nlohmann::ordered_json (*run)(const BenchOptions&);
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
    {"papers", "the comparisons of the papers: polyhedra, scans, saddle vertices", run_bench_papers, {}},
    {"calls", "the calls of a time step: a grid again, one sample, patches, vertices that move", run_bench_calls, {}},
    {"points", "points anywhere: uniform, near the surface, along rays, in many calls", run_bench_points, {}}};

void check_options(const Benchmark& chosen, const CLI::App& parser) {
    for (const Benchmark& other : benchmarks)
        for (const std::string& option : other.takes)
            if (parser.count(option) > 0 && !contains(chosen.takes, option))
                throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                                   fmt::format("{} is no option of bench {}, which takes {}{} those of all benchmarks\n"
                                               "\"clsdf bench --help\" lists the options.",
                                               option, chosen.name, fmt::join(chosen.takes, ", "),
                                               chosen.takes.empty() ? "only" : " and"));
}

/// --quick does not override options of the command line.
void make_quick(const CLI::App& parser, BenchOptions& options) {
    if (!options.quick) return;
    if (parser.count("--repetitions") == 0) options.measure.repetitions = 2;
    if (parser.count("--samples") == 0) options.measure.samples_judged = 2000;
    if (parser.count("--seconds-per-call") == 0) options.measure.seconds_per_call = 0.5;
}

void show_progress(BenchOptions& options) {
    if (options.quiet || isatty(STDERR_FILENO) == 0) return;
    options.measure.progress = [](const std::string& method) { print_text("\r\033[K{} ...\r", method); };
}

}  // namespace

Command add_bench(CLI::App& program) {
    const auto options = std::make_shared<BenchOptions>();
    CLI::App* parser = program.add_subcommand("bench", "Measure speed, and the errors of the fields that were timed");
    std::vector<std::string> names;
    names.reserve(benchmarks.size());
    for (const Benchmark& benchmark : benchmarks) names.push_back(benchmark.name);
    takes_one_of(parser->add_option("BENCHMARK", options->benchmark, "the measurement")->required(), names);
    parser->add_option("MESHES", options->meshes,
                       "files, or names: bunny00, armadillo, fandisk_large, refined_elephant (from --meshes), "
                       "noisy_sphere, and those of \"clsdf shape\"");
    parser->add_option("--meshes", options->folder, "the folder of the meshes of scripts/fetch-meshes")
        ->type_name("FOLDER")
        ->capture_default_str();
    takes_some_of(
        parser->add_option("--workload", options->workloads, "of peers and floors, separated by commas [all]"),
        {"W1", "W2", "W3", "W4"});
    takes_some_of(parser->add_option("--method", options->methods,
                                     "of peers and scaling, separated by commas [peers: all, scaling: clsdf]"),
                  {"clsdf", "again", "embree", "openvdb", "cgal"});
    takes_some_of(parser->add_option("--series", options->series, "of scaling, separated by commas [all]"),
                  {"N", "d", "triangles", "threads"});
    parser
        ->add_option("--repetitions", options->measure.repetitions,
                     "timed calls of each method, after those that warm up")
        ->check(whole_number(1, 10000))
        ->type_name("N")
        ->capture_default_str();
    parser
        ->add_option("--seconds-per-call", options->measure.seconds_per_call,
                     "of peers and scaling: a method that is asked sample by sample computes only so many bricks that "
                     "a call takes about "
                     "this long; its row says so")
        ->check(finite_number_of_0_or_more())
        ->type_name("S")
        ->capture_default_str();
    parser->add_option("--samples", options->measure.samples_judged, "samples held against the reference; 0: all")
        ->check(whole_number(0, 1'000'000'000))
        ->type_name("N")
        ->capture_default_str();
    parser->add_option("--seed", options->measure.seed, "of those samples, and of the noisy sphere")
        ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
        ->type_name("N")
        ->capture_default_str();
    add_device_option(*parser, options->device, "what computes");
    parser->add_option("--threads", options->threads, "of the processor, for all methods [all]")
        ->check(whole_number(1, 4096))
        ->type_name("N");
    parser->add_option("--commit", options->commit, "text that the record carries")->type_name("TEXT");
    parser->add_flag("--quick", options->quick, "small grids and few calls: to see that it works, not to measure");
    std::string explanation;
    for (const Benchmark& benchmark : benchmarks)
        explanation += fmt::format("{}: {}.\n", benchmark.name, benchmark.what);
    parser->footer(explanation + '\n' + examples);
    return {parser, [options, parser](Report& report) {
                const auto chosen = std::find_if(benchmarks.begin(), benchmarks.end(), [&](const Benchmark& benchmark) {
                    return benchmark.name == options->benchmark;
                });
                check_options(*chosen, *parser);
                make_quick(*parser, *options);
                options->quiet = report.quiet;
                show_progress(*options);
                std::optional<clsdf::bench::ThreadLimit> limit;
                if (options->threads > 0) limit.emplace(options->threads);
                report.result = chosen->run(*options);
                return ExitStatus::done;
            }};
}

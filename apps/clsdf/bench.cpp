#include "bench.hpp"
#include "command.hpp"
#include "option_values.hpp"

#include "benchmarks/machine.hpp"

#include <fmt/format.h>

#include <unistd.h>
#include <limits>
#include <memory>

namespace {

const char* const examples =
    "Examples:\n"
    "  clsdf bench peers bunny00 --workload W1\n"
    "  clsdf bench peers dragon.off --workload W2 --method clsdf --method embree\n"
    "  clsdf bench scaling --series N --series d --json > scaling.json\n"
    "  clsdf bench floors --quick\n"
    "  clsdf bench papers sphere6";

CLI::App* add_benchmark(CLI::App& bench, const char* name, const char* what, BenchOptions& options) {
    CLI::App* parser = bench.add_subcommand(name, what);
    parser->add_option("MESH", options.meshes,
                       "files, or names: bunny00, armadillo, fandisk_large, refined_elephant (from --meshes), "
                       "noisy_sphere, and those of \"clsdf shape\"");
    parser->add_option("--meshes", options.folder, "where scripts/fetch-meshes put the meshes")
        ->type_name("FOLDER")
        ->capture_default_str();
    parser
        ->add_option("--repetitions", options.measure.repetitions,
                     "timed calls of each method, after those that warm up")
        ->check(whole_number(1, 10000))
        ->type_name("N")
        ->capture_default_str();
    parser->add_option("--samples", options.measure.samples_judged, "samples held against the reference; 0: all")
        ->check(whole_number(0, 1'000'000'000))
        ->type_name("N")
        ->capture_default_str();
    parser->add_option("--seed", options.measure.seed, "of those samples, and of the noisy sphere")
        ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
        ->type_name("N")
        ->capture_default_str();
    parser->add_option("--device", options.device, "what computes, as in \"clsdf devices\"")->type_name("INDEX|NAME");
    parser->add_option("--threads", options.threads, "of the processor, for all methods; by default all")
        ->check(whole_number(1, 4096))
        ->type_name("N");
    parser->add_option("--commit", options.commit, "text that the record carries")->type_name("TEXT");
    parser->add_flag("--quick", options.quick, "small grids and few calls: to see that it works, not to measure");
    parser->add_flag("--json", options.json, "print the result as JSON on standard output");
    parser->add_flag("--quiet", options.quiet, "print errors only, and what --json asks for");
    parser->footer(examples);
    return parser;
}

void add_workloads(CLI::App& parser, BenchOptions& options) {
    parser.add_option("--workload", options.workloads, "W1, W2, W3 or W4, any number of times; by default all")
        ->check(CLI::IsMember({"W1", "W2", "W3", "W4"}))
        ->type_name("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_methods(CLI::App& parser, BenchOptions& options, const char* what) {
    parser.add_option("--method", options.methods, what)
        ->check(CLI::IsMember({"clsdf", "once", "embree", "openvdb", "cgal"}))
        ->type_name("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

/// --quick keeps what was stated on the command line.
void make_quick(const CLI::App& parser, BenchOptions& options) {
    if (!options.quick) return;
    if (parser.count("--repetitions") == 0) options.measure.repetitions = 2;
    if (parser.count("--samples") == 0) options.measure.samples_judged = 2000;
    options.measure.seconds_per_call = 0.5;
}

void show_progress(BenchOptions& options) {
    if (options.quiet || isatty(STDERR_FILENO) == 0) return;
    options.measure.progress = [](const std::string& method) { fmt::print(stderr, "\r\033[K{} ...\r", method); };
}

}  // namespace

Command add_bench(CLI::App& program) {
    const auto options = std::make_shared<BenchOptions>();
    CLI::App* bench = program.add_subcommand("bench", "Measure speed, with the error of what was timed beside it");
    bench->require_subcommand(1);
    bench->footer(examples);
    struct Benchmark {
        CLI::App* parser;
        ExitStatus (*run)(const BenchOptions&);
    };
    const std::vector<Benchmark> benchmarks{
        {add_benchmark(*bench, "peers", "Time the whole call beside the peers that are installed", *options),
         run_bench_peers},
        {add_benchmark(*bench, "scaling", "Time series in samples, width of the band, triangles and threads", *options),
         run_bench_scaling},
        {add_benchmark(*bench, "floors", "Measure the device's own limits, and each stage against them", *options),
         run_bench_floors},
        {add_benchmark(*bench, "papers", "Repeat what the papers compare: polyhedra, scans, saddle vertices", *options),
         run_bench_papers}};
    add_workloads(*benchmarks[0].parser, *options);
    add_workloads(*benchmarks[2].parser, *options);
    add_methods(*benchmarks[0].parser, *options,
                "clsdf, once, embree, openvdb or cgal, any number of times; by default all");
    add_methods(*benchmarks[1].parser, *options, "the same; by default clsdf");
    benchmarks[0]
        .parser
        ->add_option("--seconds-per-call", options->measure.seconds_per_call,
                     "a method that is asked sample by sample computes only so many bricks that a call takes about "
                     "this long; its row says so")
        ->check(finite_number_of_0_or_more())
        ->type_name("S")
        ->capture_default_str();
    benchmarks[1]
        .parser
        ->add_option("--series", options->series, "N, d, triangles or threads, any number of times; by default all")
        ->check(CLI::IsMember({"N", "d", "triangles", "threads"}))
        ->type_name("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    return {bench, [options, benchmarks] {
                for (const Benchmark& benchmark : benchmarks) {
                    if (!benchmark.parser->parsed()) continue;
                    make_quick(*benchmark.parser, *options);
                    show_progress(*options);
                    std::optional<clsdf::bench::ThreadLimit> limit;
                    if (options->threads > 0) limit.emplace(options->threads);
                    return benchmark.run(*options);
                }
                return ExitStatus::usage;
            }};
}

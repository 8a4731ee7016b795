// Runs the acceptance list of fields: a row per field on the terminal, a record in Markdown. Exit status 0 if every
// promise is kept, 1 if one is broken, 2 if the list could not be run.

#include "acceptance/cases.hpp"
#include "acceptance/cost.hpp"
#include "acceptance/record.hpp"
#include "core/stopwatch.hpp"

#include <clsdf/error.hpp>
#include <clsdf/tuning.hpp>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

namespace {

using namespace clsdf;
using namespace clsdf::acceptance;

struct Options {
    bool complete = false;
    bool sampled = false;
    bool list = false;
    std::string meshes;
    std::string record;
    std::string fields;
    std::string only;
    std::string commit;
    std::size_t part = 0, parts = 1;
    std::uint64_t seed = 1;
    std::string body = "automatic";
};

const std::map<std::string, std::vector<KernelBody>> bodies{{"automatic", {KernelBody::automatic}},
                                                            {"by_vector", {KernelBody::by_vector}},
                                                            {"by_group", {KernelBody::by_group}},
                                                            {"both", {KernelBody::by_vector, KernelBody::by_group}}};

/// The field whose costs are limited.
const std::string bunny = "bunny00, 256, 10%";

void append(std::vector<Case>& cases, std::vector<Case> more) {
    std::move(more.begin(), more.end(), std::back_inserter(cases));
}

std::vector<Case> cases_of(const Options& options, Record& record) {
    const Scope scope = options.complete ? Scope::complete : Scope::sampled;
    std::vector<Case> cases = counterexample_cases(scope);
    append(cases, strained_cases(scope));
    append(cases, shape_cases(scope));
    append(cases, random_cases(scope, options.seed));
    if (!options.meshes.empty()) {
        ArchiveCases archive = archive_cases(options.meshes);
        append(cases, std::move(archive.cases));
        record.unreadable = std::move(archive.unreadable);
    }
    std::erase_if(cases, [&](const Case& example) {
        return example.name.find(options.only) == std::string::npos && example.kind != options.only;
    });
    if (options.complete && options.only.empty() &&
        std::none_of(cases.begin(), cases.end(), [](const Case& example) { return example.name == bunny; }))
        throw Error(ErrorCode::unreadable_input, "the field whose costs are limited is missing: " + bunny);
    std::vector<Case> own;
    for (std::size_t n = options.part; n < cases.size(); n += options.parts) own.push_back(std::move(cases[n]));
    return own;
}

/// Flushed, so that a redirected run can be followed.
void print_line(const std::string& text) {
    fmt::print("{}\n", text);
    std::fflush(stdout);
}

void run_list(const Device& device, const std::vector<Case>& cases, const std::string& body, Record& record) {
    print_line(heading());
    for (const Case& example : cases)
        for (Result& result : run(device, example, bodies.at(body))) {
            print_line(row(result));
            fmt::print(stderr, "{}", explain(result));
            record.results.push_back(std::move(result));
        }
    const auto found =
        std::find_if(cases.begin(), cases.end(), [&](const Case& example) { return example.name == bunny; });
    if (found == cases.end() || body == "by_group") return;  // the limits are those of vectors
    print_line("\nHow well the polyhedra fit: " + bunny);
    record.costs = bunny_costs(device, found->make());
    for (const CostLimit& limit : record.costs) print_line(row(limit));
}

int run_all(const Options& options, std::string command) {
    const Stopwatch stopwatch;
    Record record;
    record.command = std::move(command);
    record.commit = options.commit;
    const std::vector<Case> cases = cases_of(options, record);
    if (cases.empty()) throw Error(ErrorCode::invalid_argument, "no field of the list is named so: " + options.only);
    if (options.list) {
        for (const Case& example : cases) print_line(fmt::format("{:<24} {}", example.kind, example.name));
        return 0;
    }
    const Device device = Device::strongest();
    record.device = fmt::format("{} ({})", device.name(), device.platform());
    print_line(fmt::format("{} fields on {}; * marks what is checked at every sample\n",
                           cases.size() * bodies.at(options.body).size(), record.device));
    run_list(device, cases, options.body, record);
    record.seconds = stopwatch.seconds();

    const auto failed = std::count_if(record.results.begin(), record.results.end(),
                                      [](const Result& result) { return !result.passed(); });
    print_line(fmt::format("\n{} of {} fields failed; {:.0f} s: {}", failed, record.results.size(), record.seconds,
                           record.passed() ? "passed" : "FAILED"));
    if (!options.record.empty()) write_summary(record, options.record);
    if (!options.fields.empty()) write_fields(record, options.fields);
    return record.passed() ? 0 : 1;
}

}  // namespace

int main(int argument_count, char** arguments) {
    tuning::read_environment();
    CLI::App app("Computes the fields by which clsdf is accepted and holds them against the reference.");
    Options options;
    auto* const complete = app.add_flag("--complete", options.complete,
                                        "The whole list, for a record; needs --meshes unless --only is given");
    auto* const sampled =
        app.add_flag("--sampled", options.sampled, "Small grids and few samples of the meshes made by code: a test");
    complete->excludes(sampled);
    auto* const meshes = app.add_option("--meshes", options.meshes, "Folder of the meshes of CGAL's data");
    meshes->check(CLI::ExistingDirectory);
    app.add_option("--only", options.only, "Fields whose name holds this text, or of this kind");
    auto* const parts = app.add_option("--parts", options.parts, "Divide the list into so many parts");
    app.add_option("--part", options.part, "The part of them to compute, from 0 on")->needs(parts);
    app.add_option("--seed", options.seed, "First seed of the random meshes")->capture_default_str();
    app.add_option("--body", options.body, "The kernels' body: automatic, by_vector, by_group, or both of these")
        ->check(CLI::IsMember(bodies))
        ->take_last()
        ->capture_default_str();
    app.add_option("--commit", options.commit, "For the record: the commit that was built");
    app.add_option("--record", options.record, "Write a summary to this Markdown file");
    app.add_option("--fields", options.fields, "Write what was found field by field to this Markdown file");
    app.add_flag("--list", options.list, "Only list the fields");
    CLI11_PARSE(app, argument_count, arguments);
    if (!options.complete && !options.sampled) {
        fmt::print(stderr, "acceptance: say --complete or --sampled\n");
        return 2;
    }
    if (options.part >= options.parts) {
        fmt::print(stderr, "acceptance: there is no part {} of {}; parts count from 0\n", options.part, options.parts);
        return 2;
    }
    if (options.complete && options.meshes.empty() && options.only.empty()) {
        fmt::print(stderr, "acceptance: the complete list needs --meshes FOLDER (scripts/fetch-meshes gets them)\n");
        return 2;
    }
    std::string command = "acceptance";
    for (int i = 1; i < argument_count; ++i) command += fmt::format(" {}", arguments[i]);
    try {
        return run_all(options, command);
    } catch (const std::exception& error) {
        fmt::print(stderr, "acceptance: {}\n", error.what());
        return 2;
    }
}

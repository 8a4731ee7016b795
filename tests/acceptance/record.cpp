#include "acceptance/record.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <thread>

namespace clsdf::acceptance {

namespace {

std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown processor";
}

std::string size_of(const Index3& size) {
    return fmt::format("{}x{}x{}", size[0], size[1], size[2]);
}

/// The wrong samples of all outputs beside the distance.
std::size_t wrong_outputs_of(const reference::CheckReport& report) {
    std::size_t sum = 0;
    for (const OutputInfo& info : output_table()) sum += report.wrong_outputs[detail::index_of(info.output)];
    return sum;
}

/// The sums over the cases of a kind.
struct Summary {
    std::string kind;
    std::size_t cases = 0, complete = 0, failed = 0, samples = 0, band_samples = 0, beyond_aim = 0;
    std::size_t wrong_values = 0, wrong_signs = 0, missed = 0, leaked = 0, wrong_outputs = 0;
    double max_error_voxels = 0, max_error_ulp = 0;

    void add(const Result& result) {
        const reference::CheckReport& report = result.judged;
        ++cases;
        complete += result.every_sample ? 1U : 0U;
        failed += result.passed() ? 0U : 1U;
        samples += report.samples;
        band_samples += report.band_samples;
        beyond_aim += result.beyond_aim;
        wrong_values += report.wrong_values;
        wrong_signs += report.wrong_signs;
        missed += report.missed;
        leaked += report.leaked;
        wrong_outputs += wrong_outputs_of(report);
        max_error_voxels = std::max(max_error_voxels, report.max_error_voxels);
        max_error_ulp = std::max(max_error_ulp, report.max_error_ulp);
    }
};

std::vector<Summary> sum_up(const std::vector<Result>& results) {
    std::vector<Summary> summaries;
    Summary total;
    total.kind = "**all**";
    for (const Result& result : results) {
        auto summary = std::find_if(summaries.begin(), summaries.end(),
                                    [&](const Summary& known) { return known.kind == result.kind; });
        if (summary == summaries.end()) {
            summary = summaries.insert(summaries.end(), Summary{});
            summary->kind = result.kind;
        }
        summary->add(result);
        total.add(result);
    }
    summaries.push_back(total);
    return summaries;
}

std::string introduction(const Record& record) {
    const std::time_t now = std::time(nullptr);
    const Summary total = sum_up(record.results).back();
    std::string text = fmt::format(
        "# Acceptance\n\n"
        "Fields of the list, computed and held against the reference in double precision, with all outputs. Each is "
        "held\n"
        "against other calls, too: requests, a restricted transform, points and a moved mesh, in blocks that have "
        "samples\n"
        "of the band; and points off the grid, many and few at once.\n"
        "`scripts/accept` makes this record, and the list field by field in build/acceptance.md.\n\n"
        "| | |\n|-|-|\n"
        "| outcome | {}: {} fields, {} failed |\n",
        record.passed() ? "passed" : "**FAILED**", total.cases, total.failed);
    text += fmt::format("| samples checked | {}, {} of them in the band; {} fields at every sample |\n", total.samples,
                        total.band_samples, total.complete);
    text += fmt::format("| wrong | {} values, {} signs, {} missed, {} leaked, {} outputs beside the distance |\n",
                        total.wrong_values, total.wrong_signs, total.missed, total.leaked, total.wrong_outputs);
    text += fmt::format(
        "| largest error | {:.2g} voxel; {} samples beyond the aim of max({:g} voxel, 2 ulp), {} beyond "
        "max({:g} voxel, 2 ulp) |\n",
        total.max_error_voxels, total.beyond_aim, aim_voxels, total.wrong_values, judged_voxels);
    text += fmt::format("| version | {}{} |\n", version(),
                        record.commit.empty() ? "" : fmt::format(", commit {}", record.commit));
    text += fmt::format("| date | {:%Y-%m-%d %H:%M} UTC |\n", fmt::gmtime(now));
    text += fmt::format("| machine | {}, {} threads |\n", processor(), std::thread::hardware_concurrency());
    text += fmt::format("| device | {} |\n", record.device);
    text += fmt::format("| command | `{}`, {:.0f} s |\n", record.command, record.seconds);
    return text;
}

std::string costs_table(const std::vector<CostLimit>& costs) {
    if (costs.empty()) return {};
    std::string text =
        "\n## How well the polyhedra fit\n\nbunny00, 256 samples, half width 10%.\n\n"
        "| | found | from | to | |\n|-|-:|-:|-:|-|\n";
    for (const CostLimit& limit : costs)
        text += fmt::format("| {} | {:.4g} | {:g} | {:g} | {} |\n", limit.name, limit.found, limit.least, limit.most,
                            limit.kept() ? "kept" : "**broken**");
    return text;
}

std::string summary_table(const std::vector<Result>& results) {
    std::string text =
        "\n## By kind of mesh\n\n"
        "| kind | fields | of them complete | failed | samples | in the band | max error, voxel | max error, ulp | "
        "beyond the aim | wrong values | wrong signs | missed | leaked | wrong outputs |\n"
        "|-|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|\n";
    for (const Summary& s : sum_up(results))
        text +=
            fmt::format("| {} | {} | {} | {} | {} | {} | {:.2g} | {:.2f} | {} | {} | {} | {} | {} | {} |\n", s.kind,
                        s.cases, s.complete, s.failed, s.samples, s.band_samples, s.max_error_voxels, s.max_error_ulp,
                        s.beyond_aim, s.wrong_values, s.wrong_signs, s.missed, s.leaked, s.wrong_outputs);
    return text;
}

std::string results_table(const std::vector<Result>& results) {
    std::string text =
        "\n## Every field\n\n"
        "| field | triangles | grid | half width, voxel | sign | samples | in the band | max error, voxel | max error, "
        "ulp | beyond the aim | wrong values | wrong signs | missed | leaked | wrong outputs | computed, s | "
        "checked, "
        "s | |\n|-|-:|-|-:|-|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|-:|-|\n";
    for (const Result& r : results) {
        if (!r.error.empty()) {
            text += fmt::format("| {} | | | | | | | | | | | | | | | | | **{}** |\n", r.name, r.error);
            continue;
        }
        text += fmt::format(
            "| {} | {} | {} | {:.1f} | {} | {} | {} | {:.2g} | {:.2f} | {} | {} | {} | {} | {} | {} | {:.2f} | {:.1f} "
            "| "
            "{} |\n",
            r.name, r.triangles, size_of(r.size), r.half_width_voxels, name_of(r.sign),
            r.every_sample ? "all" : fmt::format("{}", r.judged.samples), r.judged.band_samples,
            r.judged.max_error_voxels, r.judged.max_error_ulp, r.beyond_aim, r.judged.wrong_values,
            r.judged.wrong_signs, r.judged.missed, r.judged.leaked, wrong_outputs_of(r.judged), r.compute_seconds,
            r.check_seconds, r.passed() ? "" : "**FAILED**");
    }
    return text;
}

std::string breaches(const std::vector<Result>& results) {
    std::string text;
    for (const Result& result : results) text += explain(result);
    return text.empty() ? text : fmt::format("\n## What was wrong\n\n```\n{}```\n", text);
}

std::string unreadable_files(const std::vector<std::string>& messages) {
    if (messages.empty()) return {};
    std::string text = "\n## Files of the archive that hold no mesh\n\n";
    for (const std::string& message : messages) text += fmt::format("- {}\n", message);
    return text;
}

}  // namespace

bool Record::passed() const {
    return !results.empty() &&
           std::all_of(results.begin(), results.end(), [](const Result& result) { return result.passed(); }) &&
           std::all_of(costs.begin(), costs.end(), [](const CostLimit& limit) { return limit.kept(); });
}

std::string heading() {
    return fmt::format("{:<46} {:>8} {:>13} {:>5} {:>9} {:>8} {:>5} {:>7} {:>6} {:>6} {:>6} {:>6} {:>6} {:>8} {:>7}",
                       "field", "faces", "grid", "band", "in band", "voxel", "ulp", "beyond", "values", "signs",
                       "missed", "leaked", "faces", "compute", "check");
}

std::string row(const Result& r) {
    if (!r.error.empty()) return fmt::format("{:<46} FAILED: {}", r.name, r.error);
    return fmt::format(
        "{:<46} {:>8} {:>13} {:>5.1f} {:>8}{} {:>8.2g} {:>5.2f} {:>7} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7.2f}s "
        "{:>6.1f}s{}",
        r.name, r.triangles, size_of(r.size), r.half_width_voxels, r.judged.band_samples, r.every_sample ? '*' : ' ',
        r.judged.max_error_voxels, r.judged.max_error_ulp, r.beyond_aim, r.judged.wrong_values, r.judged.wrong_signs,
        r.judged.missed, r.judged.leaked, wrong_outputs_of(r.judged), r.compute_seconds, r.check_seconds,
        r.passed() ? "" : "  FAILED");
}

std::string row(const CostLimit& limit) {
    return fmt::format("{:<46} {:.4g}, from {:g} to {:g}{}", limit.name, limit.found, limit.least, limit.most,
                       limit.kept() ? "" : "  FAILED");
}

std::string explain(const Result& result) {
    if (result.passed()) return {};
    if (!result.error.empty()) return fmt::format("{}: {}\n", result.name, result.error);
    if (!result.wrong_calls.empty()) return fmt::format("{}: {}\n", result.name, result.wrong_calls);
    if (result.judged.band_samples == 0) return fmt::format("{}: no sample in the band was checked\n", result.name);
    std::string text;
    for (const reference::CheckReport::Finding& finding : result.judged.findings)
        text +=
            fmt::format("{}: sample ({}, {}, {}) is {:.9g} instead of {:.17g}: {}\n", result.name, finding.sample[0],
                        finding.sample[1], finding.sample[2], finding.found, finding.expected, finding.what);
    return text;
}

namespace {

void write_text(const std::string& text, const std::string& path) {
    std::ofstream file(path);
    file << text;
    file.close();
    if (!file) throw Error(ErrorCode::output_failure, fmt::format("the record could not be written to {}", path));
}

}  // namespace

void write_summary(const Record& record, const std::string& path) {
    write_text(introduction(record) + breaches(record.results), path);
}

void write_fields(const Record& record, const std::string& path) {
    write_text(introduction(record) + costs_table(record.costs) + summary_table(record.results) +
                   breaches(record.results) + results_table(record.results) + unreadable_files(record.unreadable),
               path);
}

}  // namespace clsdf::acceptance

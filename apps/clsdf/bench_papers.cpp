#include "bench.hpp"
#include "nearest_word.hpp"
#include "report.hpp"

#include "benchmarks/papers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

using clsdf::bench::Measurement;
using clsdf::bench::PapersCase;
using clsdf::bench::PapersMethod;
using clsdf::bench::Work;
using clsdf::bench::Workload;

namespace {

struct PapersRow {
    const char* mesh;
    std::size_t vertices, saddles, gaps;
};
/// Peikert & Sigg's Table 1; their bunny is another triangulation than bunny00.
constexpr std::array<PapersRow, 5> table_1{{{"sphere6", 16386, 0, 0},
                                            {"torus", 3000, 1788, 0},
                                            {"knot", 1440, 1378, 674},
                                            {"seashell", 915, 843, 148},
                                            {"bunny00", 34834, 30561, 516}}};

/// Nothing if the mesh was not named or is missing.
const clsdf::Mesh* find_mesh(const std::vector<NamedMesh>& meshes, const std::string& name) {
    const auto found = std::find_if(meshes.begin(), meshes.end(), [&](const auto& mesh) { return mesh.name == name; });
    return found == meshes.end() ? nullptr : &found->mesh;
}

Json count_saddles(const std::vector<NamedMesh>& meshes, const BenchOptions& options) {
    BenchTable table({"mesh", "paper: vertices", "saddles", "gaps", "here: vertices", "saddles", "gaps, adjacent pairs",
                      "gaps, all pairs"});
    Json rows = Json::array();
    for (const PapersRow& paper : table_1) {
        const clsdf::Mesh* const mesh = find_mesh(meshes, paper.mesh);
        if (mesh == nullptr) continue;
        const clsdf::SaddleReport report = examine_saddles(*mesh);
        const std::array<std::size_t, 7> counts{paper.vertices,          paper.saddles,  paper.gaps,
                                                mesh->vertices().size(), report.saddles, report.adjacent_gaps.size(),
                                                report.gaps.size()};
        std::vector<std::string> cells{paper.mesh};
        for (const std::size_t count : counts) cells.push_back(std::to_string(count));
        table.add(std::move(cells));
        rows.push_back({{"mesh", paper.mesh},
                        {"paper", {{"vertices", counts[0]}, {"saddles", counts[1]}, {"gaps", counts[2]}}},
                        {"vertices", counts[3]},
                        {"saddles", counts[4]},
                        {"gaps_of_adjacent_pairs", counts[5]},
                        {"gaps", counts[6]}});
    }
    options.say(fmt::format("Table 1: saddle vertices and gaps\n\n{}", table.text()));
    return rows;
}

double median_wall(const Measurement& measurement) {
    return clsdf::bench::spread_of(measurement.wall).median;
}

/// The share of judged samples of the band whose value is wrong or missing.
double wrong_percent(const clsdf::bench::Judgement& judgement) {
    return 100.0 * static_cast<double>(judgement.wrong_values + judgement.missed) /
           static_cast<double>(std::max<std::size_t>(judgement.samples, 1));
}

Json measure_case(const PapersCase& c, const Workload& workload,
                  const std::vector<std::unique_ptr<PapersMethod>>& methods, const BenchOptions& options) {
    std::vector<clsdf::bench::Method*> timed;
    timed.reserve(methods.size());
    for (const auto& method : methods) timed.push_back(method.get());
    const std::vector<Measurement> measurements = measure_in_turns(workload, timed, options.measure);
    const double one_thread = median_wall(measurements[0]), all_threads = median_wall(measurements[1]);
    const auto band = static_cast<double>(workload.list.samples.size());

    BenchTable table({"method", "least, ms", "median", "most", "times software, 1 thread", "times software, all",
                      "polyhedra", "distances per band sample", "wrong or missed, %", "max error, voxel",
                      "wrong values", "wrong signs", "missed", "leaked", "judged"});
    Json rows = Json::array();
    for (std::size_t i = 0; i < methods.size(); ++i) {
        const Measurement& m = measurements[i];
        const Work work = methods[i]->work(workload);
        const clsdf::bench::Spread wall = clsdf::bench::spread_of(m.wall);
        const double per_sample = static_cast<double>(work.distances) / band;
        std::vector<std::string> cells{m.method,
                                       milliseconds(wall.least),
                                       milliseconds(wall.median),
                                       milliseconds(wall.most),
                                       fmt::format("{:.2f}", one_thread / wall.median),
                                       fmt::format("{:.2f}", all_threads / wall.median),
                                       std::to_string(work.polyhedra),
                                       fmt::format("{:.2f}", per_sample),
                                       fmt::format("{:.3f}", wrong_percent(m.judgement))};
        for (std::string& cell : cells_of(m.judgement)) cells.push_back(std::move(cell));
        table.add(std::move(cells));
        Json row = ::describe(workload);
        row.update(::describe(m));
        row["speed_up_over_software_one_thread"] = one_thread / wall.median;
        row["speed_up_over_software_all_threads"] = all_threads / wall.median;
        row["polyhedra"] = work.polyhedra;
        row["distances_per_band_sample"] = per_sample;
        row["wrong_percent"] = wrong_percent(m.judgement);
        rows.push_back(std::move(row));
    }
    options.say(
        fmt::format("\n{}{}\n\n{}", title_of(workload), c.remark.empty() ? "" : " (" + c.remark + ")", table.text()));
    return rows;
}

Json measure_scans(const std::vector<NamedMesh>& meshes, const clsdf::Device& device, const BenchOptions& options) {
    Json rows = Json::array();
    for (PapersCase c : clsdf::bench::papers_cases()) {
        const clsdf::Mesh* const mesh = find_mesh(meshes, c.mesh);
        if (mesh == nullptr) continue;
        c.resolution = options.scaled(c.resolution);
        // The paper's figures are for its own grid.
        if (options.quick) c.remark.clear();
        const Workload workload = make_workload(c.layout(), c.mesh, *mesh, device);
        const auto methods = clsdf::bench::papers_methods(device, workload);
        const Json measured = measure_case(c, workload, methods, options);
        for (const Json& row : measured.elements()) rows.push_back(row);
    }
    return rows;
}

/// A row for each method of a comparison, also for those that are not built in: these say how to get them.
struct Comparison {
    std::vector<Measurement> measurements;  ///< of the methods that are built in, in their order
    std::vector<const clsdf::bench::Entry*> absent;
};

Comparison compare(const Workload& workload, const std::vector<clsdf::bench::Entry>& entries,
                   const BenchOptions& options) {
    std::vector<clsdf::bench::Method*> timed;
    Comparison comparison;
    for (const clsdf::bench::Entry& entry : entries)
        if (entry.method)
            timed.push_back(entry.method.get());
        else
            comparison.absent.push_back(&entry);
    comparison.measurements = measure_in_turns(workload, timed, options.measure);
    return comparison;
}

/// Time beside error, and the first method's median time divided by each one's.
BenchTable comparison_table(const char* parameter) {
    return BenchTable({parameter, "samples on a side", "method", "least, ms", "median", "most", "times the first",
                       "mean error, voxel", "max error, voxel", "wrong values", "wrong signs", "missed", "leaked",
                       "judged"});
}

void add_rows(const std::string& parameter, const Workload& workload, const Comparison& comparison, BenchTable& table,
              Json& rows) {
    const double first = median_wall(comparison.measurements.front());
    const std::string side = std::to_string(workload.grid.size[0]);
    for (const Measurement& m : comparison.measurements) {
        const clsdf::bench::Spread wall = clsdf::bench::spread_of(m.wall);
        std::vector<std::string> cells{parameter,
                                       side,
                                       m.method,
                                       milliseconds(wall.least),
                                       milliseconds(wall.median),
                                       milliseconds(wall.most),
                                       fmt::format("{:.3g}", first / wall.median),
                                       fmt::format("{:.2g}", m.judgement.mean_error_voxels)};
        for (std::string& cell : cells_of(m.judgement)) cells.push_back(std::move(cell));
        table.add(std::move(cells));
        Json row = ::describe(workload);
        row.update(::describe(m));
        row["speed_up_over_first"] = first / wall.median;
        rows.push_back(std::move(row));
    }
    for (const clsdf::bench::Entry* entry : comparison.absent) {
        std::vector<std::string> cells{parameter, side, fmt::format("{}: {}", entry->name, entry->remedy)};
        cells.resize(14, "-");
        table.add(std::move(cells));
        Json row = ::describe(workload);
        row["method"] = entry->name;
        row["remedy"] = entry->remedy;
        rows.push_back(std::move(row));
    }
}

/// The paper computes a band, and leaves the far field to methods that continue it.
Json measure_far_field(const std::vector<NamedMesh>& meshes, const clsdf::Device& device, const BenchOptions& options) {
    const std::vector<clsdf::bench::Entry> methods = clsdf::bench::far_field_methods(device);
    Json rows = Json::array();
    for (const std::string& name : clsdf::bench::far_field_meshes()) {
        const clsdf::Mesh* const mesh = find_mesh(meshes, name);
        if (mesh == nullptr) continue;
        const Workload workload = clsdf::bench::make_workload(
            {"far field", options.scaled(256), clsdf::Length::infinite()}, name, *mesh, device);
        BenchTable table = comparison_table("mesh");
        add_rows(name, workload, compare(workload, methods, options), table, rows);
        options.say(fmt::format("\n{}\nscripts/far-field measures scikit-fmm's fast marching.\n\n{}",
                                title_of(workload), table.text()));
    }
    return rows;
}

double median_of(const std::vector<Measurement>& measurements, const std::string& method) {
    const auto found = std::find_if(measurements.begin(), measurements.end(),
                                    [&](const Measurement& measurement) { return measurement.method == method; });
    return median_wall(*found);
}

/// The faster of two methods on either side of each crossover.
std::string describe_crossovers(const std::string& first, const std::string& second,
                                const std::vector<clsdf::bench::TimesOfTwo>& times,
                                const std::vector<double>& crossovers) {
    const bool first_is_faster = times.front().first < times.front().second;
    const std::string& at_first = first_is_faster ? first : second;
    if (crossovers.empty()) {
        double least = INFINITY, most = 0;
        for (const clsdf::bench::TimesOfTwo& t : times) {
            const double ratio = first_is_faster ? t.second / t.first : t.first / t.second;
            least = std::min(least, ratio);
            most = std::max(most, ratio);
        }
        return fmt::format("no crossover: {} takes {:.1f} to {:.1f} times as long as {}",
                           first_is_faster ? second : first, least, most, at_first);
    }
    return fmt::format("crossover at {:.3g} triangles per voxel; with fewer triangles {} is faster than {}",
                       fmt::join(crossovers, " and "), at_first, first_is_faster ? second : first);
}

/// Grids that are coarse for their mesh: the paper expects a search from each sample to be faster there.
Json measure_under_sampled(const std::vector<NamedMesh>& meshes, const clsdf::Device& device,
                           const BenchOptions& options) {
    const std::vector<clsdf::bench::Entry> methods = clsdf::bench::under_sampled_methods(device);
    Json rows = Json::array(), found = Json::array();
    for (const char* series : {"sphere6", "bunny00"}) {
        const clsdf::Mesh* const mesh = find_mesh(meshes, series);
        if (mesh == nullptr) continue;
        const auto cases = clsdf::bench::under_sampled_cases(series, *mesh, options.quick);
        for (const auto& [band, half_width] :
             {std::pair{"10%", clsdf::Length::of_extent(0.1)}, std::pair{"every sample", clsdf::Length::infinite()}}) {
            BenchTable table = comparison_table("triangles per voxel");
            std::vector<clsdf::bench::TimesOfTwo> anew, again;
            for (const clsdf::bench::UnderSampledCase& c : cases) {
                const Workload workload =
                    make_workload(c.layout(half_width), clsdf::bench::short_name(c.mesh.name()), c.mesh, device);
                const Comparison comparison = compare(workload, methods, options);
                const double per_voxel = 1 / mean_area_voxels(workload);
                add_rows(fmt::format("{:.3g}", per_voxel), workload, comparison, table, rows);
                const auto median = [&](const char* name) { return median_of(comparison.measurements, name); };
                anew.push_back({per_voxel, median("bricks"), median("tree of points")});
                again.push_back({per_voxel, median("bricks, again"), median("tree of points, again")});
            }
            std::string lines;
            for (const auto& [calls, times] : {std::pair{"from arrays", &anew}, std::pair{"again", &again}}) {
                const std::vector<double> crossovers = clsdf::bench::crossovers(*times);
                const std::string line = describe_crossovers("bricks", "tree of points", *times, crossovers);
                lines += fmt::format("{}: {}\n", calls, line);
                found.push_back({{"series", series},
                                 {"band", band},
                                 {"calls", calls},
                                 {"triangles_per_voxel", crossovers},
                                 {"text", line}});
            }
            options.say(fmt::format("\nunder-sampled grids, {}, {}\n\n{}\n{}", series, band, table.text(), lines));
        }
    }
    return {{"rows", rows}, {"crossovers", found}};
}

/// The papers compare their own meshes.
std::vector<NamedMesh> load_papers_meshes(const BenchOptions& options) {
    std::vector<std::string> known;
    known.reserve(table_1.size());
    for (const PapersRow& row : table_1) known.emplace_back(row.mesh);
    for (const PapersCase& c : clsdf::bench::papers_cases())
        if (!contains(known, c.mesh)) known.push_back(c.mesh);
    for (const std::string& mesh : options.meshes)
        if (!contains(known, mesh))
            throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                               fmt::format("bench papers compares meshes of the papers: one of {}, not '{}'{}",
                                           fmt::join(known, ", "), mesh, did_you_mean(nearest_word(mesh, known))));
    return options.load_meshes(known);
}

}  // namespace

Json run_bench_papers(const BenchOptions& options) {
    const std::vector<std::string> series = options.series_of({"table-1", "scans", "far-field", "under-sampled"});
    const std::vector<NamedMesh> meshes = load_papers_meshes(options);
    const clsdf::Device device = options.open_device();
    Json result = describe_run("papers", options, device);
    if (contains(series, "table-1")) result["table_1"] = count_saddles(meshes, options);
    if (contains(series, "scans")) result["rows"] = measure_scans(meshes, device, options);
    if (contains(series, "far-field")) result["far_field"] = measure_far_field(meshes, device, options);
    if (contains(series, "under-sampled")) result["under_sampled"] = measure_under_sampled(meshes, device, options);
    return result;
}

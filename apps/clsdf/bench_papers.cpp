#include "bench.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include "benchmarks/papers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

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
    const std::vector<NamedMesh> meshes = load_papers_meshes(options);
    const clsdf::Device device = options.open_device();
    Json result = describe_run("papers", options, device);
    result["table_1"] = count_saddles(meshes, options);
    result["rows"] = Json::array();
    for (PapersCase c : clsdf::bench::papers_cases()) {
        const clsdf::Mesh* const mesh = find_mesh(meshes, c.mesh);
        if (mesh == nullptr) continue;
        c.resolution = options.scaled(c.resolution);
        // The paper's figures are for its own grid.
        if (options.quick) c.remark.clear();
        const Workload workload = make_workload(c.layout(), c.mesh, *mesh, device);
        const auto methods = clsdf::bench::papers_methods(device, workload);
        const Json rows = measure_case(c, workload, methods, options);
        for (const Json& row : rows.elements()) result["rows"].push_back(row);
    }
    return result;
}

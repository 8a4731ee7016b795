#include "bench.hpp"
#include "report.hpp"

#include "benchmarks/machine.hpp"

#include <fmt/format.h>

#include <algorithm>

using clsdf::bench::Judgement;
using clsdf::bench::Measurement;
using clsdf::bench::Workload;
using nlohmann::ordered_json;

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

ordered_json describe_run(const char* benchmark, const BenchOptions& options, const clsdf::Device& device) {
    const clsdf::bench::Machine machine = clsdf::bench::this_machine(options.threads);
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

ordered_json describe(const Workload& workload) {
    return {{"workload", workload.name},
            {"mesh", workload.mesh_name},
            {"triangles", workload.mesh.triangles().size()},
            {"grid", describe(workload.grid)},
            {"half_width_voxels", workload.band.outside / workload.grid.voxel()},
            {"sign", name_of(workload.sign)},
            {"band_samples", workload.list.samples.size()}};
}

ordered_json describe(const Judgement& judgement) {
    return {{"exact", judgement.exact()},
            {"samples", judgement.samples},
            {"max_error_voxels", judgement.max_error_voxels},
            {"wrong_values", judgement.wrong_values},
            {"wrong_signs", judgement.wrong_signs},
            {"missed", judgement.missed},
            {"leaked", judgement.leaked}};
}

ordered_json describe(const Measurement& measurement) {
    const auto spread = [](const std::vector<double>& values) -> ordered_json {
        const clsdf::bench::Spread s = clsdf::bench::spread_of(values);
        return {{"least", s.least}, {"median", s.median}, {"most", s.most}, {"each", values}};
    };
    return {{"method", measurement.method},
            {"note", measurement.note},
            {"stride", measurement.stride},
            {"wall_seconds", spread(measurement.wall)},
            {"processor_seconds", spread(measurement.processor)},
            {"peak_bytes", measurement.peak_bytes ? ordered_json(*measurement.peak_bytes) : ordered_json()},
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
    return fmt::format("{}, {}: {} triangles, {} x {} x {} samples, {}, {} with their distance", workload.name,
                       workload.mesh_name, workload.mesh.triangles().size(), size[0], size[1], size[2], band,
                       workload.list.samples.size());
}

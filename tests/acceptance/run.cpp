#include "acceptance/run.hpp"

#include "acceptance/calls.hpp"
#include "core/stopwatch.hpp"

#include <clsdf/error.hpp>
#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <utility>

namespace clsdf::acceptance {

namespace {

reference::CheckOptions options_of(const Case& example, double tolerance_voxels) {
    reference::CheckOptions options;
    options.samples = example.samples;
    options.tolerance_voxels = tolerance_voxels;
    return options;
}

/// The result of a check against the aim: only values may be wrong, and none by more than the bound.
bool is_within_bound(reference::CheckReport report) {
    report.wrong_values = 0;
    return report.passed() && report.max_error_voxels <= judged_voxels;
}

/// All outputs of fields up to 2^26 samples; only the triangle of larger fields, to save memory.
OutputSet outputs_of(const Grid& grid) {
    OutputSet outputs = Output::triangle;
    if (grid.sample_count() <= std::size_t{1} << 26)
        for (const OutputInfo& info : output_table()) outputs.insert(info.output);
    return outputs;
}

const char* name_of(KernelBody body) {
    return body == KernelBody::by_vector ? "by vector" : body == KernelBody::by_group ? "by group" : "automatic";
}

/// A field that meets the aim meets the judged bound, too; any other is checked again.
void judge(const Problem& problem, const Case& example, const Field& field, reference::CheckReport against_aim,
           Result& result) {
    result.judged = std::move(against_aim);
    result.beyond_aim = result.judged.wrong_values;
    if (is_within_bound(result.judged)) {
        result.judged.wrong_values = 0;
        result.judged.findings.clear();
    } else {
        result.judged = reference::check(problem.mesh, field, options_of(example, judged_voxels));
    }
    result.every_sample = result.judged.samples == problem.grid.sample_count();
}

void compute_and_check(const Device& device, const Case& example, std::span<const KernelBody> bodies,
                       std::vector<Result>& results) {
    const Problem problem = example.make();
    std::vector<DistanceTransform> transforms;
    std::vector<Field> fields;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        transforms.emplace_back(device, problem.mesh, TransformOptions{.sign = problem.sign, .body = bodies[i]});
        try {
            const Stopwatch computing;
            fields.push_back(transforms[i].compute(problem.grid, problem.band, outputs_of(problem.grid)));
            results[i].compute_seconds = computing.seconds();
        } catch (const Error& error) {
            throw Error(error.code(), fmt::format("{}: {}", name_of(bodies[i]), error.what()));
        }
    }
    const Stopwatch checking;
    std::vector<reference::CheckReport> reports =
        reference::check(problem.mesh, fields, options_of(example, aim_voxels));
    const double shared_seconds = checking.seconds() / static_cast<double>(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        Result& result = results[i];
        result.triangles = problem.mesh.triangles().size();
        result.size = problem.grid.size;
        result.half_width_voxels = problem.band.outside / problem.grid.voxel();
        result.sign = fields[i].sign;
        const Stopwatch judging;
        judge(problem, example, fields[i], std::move(reports[i]), result);
        result.check_seconds = shared_seconds + judging.seconds();
        result.wrong_calls = wrong_calls(transforms[i], problem, fields[i], {example.samples / 25, example.has_points});
    }
}

}  // namespace

std::vector<Result> run(const Device& device, const Case& example, std::span<const KernelBody> bodies) {
    std::vector<Result> results(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        results[i].kind = example.kind;
        results[i].name = example.name;
        if (bodies.size() > 1) results[i].name += fmt::format(", {}", name_of(bodies[i]));
    }
    try {
        compute_and_check(device, example, bodies, results);
    } catch (const Error& error) {
        for (Result& result : results) result.error = error.what();
    }
    return results;
}

}  // namespace clsdf::acceptance

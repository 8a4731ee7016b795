#include "acceptance/run.hpp"

#include "acceptance/calls.hpp"
#include "core/stopwatch.hpp"

#include <clsdf/error.hpp>

namespace clsdf::acceptance {

namespace {

reference::CheckReport check(const Mesh& mesh, const Field& field, std::size_t samples, double tolerance_voxels) {
    reference::CheckOptions options;
    options.samples = samples;
    options.tolerance_voxels = tolerance_voxels;
    return reference::check(mesh, field, options);
}

/// The result of a check against the aim: only values may be wrong, and none by more than the bound.
bool is_within_bound(reference::CheckReport report) {
    report.wrong_values = 0;
    return report.passed() && report.max_error_voxels <= judged_voxels;
}

/// All outputs of fields up to 2^26 samples; only the triangle of larger fields, to save memory.
Outputs outputs_of(const Grid& grid) {
    Outputs outputs;
    const bool is_large = grid.sample_count() > std::size_t{1} << 26;
    visit_extras([&](const char*, bool& wanted) { wanted = !is_large; }, outputs);
    outputs.triangle = true;
    return outputs;
}

void compute_and_check(const Device& device, const Case& example, KernelBody body, Result& result) {
    const Problem problem = example.make();
    result.triangles = problem.mesh.triangles().size();
    result.size = problem.grid.size;
    result.half_width_voxels = problem.band.outside / problem.grid.voxel();

    DistanceTransform transform(device, problem.mesh, {.sign = problem.sign, .body = body});
    const Stopwatch computing;
    const Field field = transform(problem.grid, problem.band, outputs_of(problem.grid));
    result.compute_seconds = computing.seconds();
    result.sign = field.sign;

    const Stopwatch checking;
    result.judged = check(problem.mesh, field, example.samples, aim_voxels);
    result.beyond_aim = result.judged.wrong_values;
    // A field that meets the aim meets the judged bound, too; the others are checked again.
    if (is_within_bound(result.judged)) {
        result.judged.wrong_values = 0;
        result.judged.findings.clear();
    } else {
        result.judged = check(problem.mesh, field, example.samples, judged_voxels);
    }
    result.check_seconds = checking.seconds();
    result.wrong_calls = wrong_calls(transform, problem, field);
    result.every_sample = result.judged.samples == problem.grid.sample_count();
}

}  // namespace

Result run(const Device& device, const Case& example, KernelBody body) {
    Result result;
    result.kind = example.kind;
    result.name = example.name;
    try {
        compute_and_check(device, example, body, result);
    } catch (const Error& error) {
        result.error = error.what();
    }
    return result;
}

}  // namespace clsdf::acceptance

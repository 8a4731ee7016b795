#include "benchmarks/calls.hpp"

#include "benchmarks/call_job.hpp"
#include "benchmarks/points.hpp"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <span>
#include <string>

namespace clsdf::bench {

namespace {

CallCost measure_again(const CallJob& job, CallJudge& judge) {
    CallCost cost{"again", "the same grid and band on a kept transform / its first call"};
    cost.limit = 0.75;
    const Grid grid = job.grid(256);
    Field field = job.transform().compute(grid, CallJob::band(grid));
    std::unique_ptr<DistanceTransform> transform;
    const auto compute = [&] { transform->compute(grid, CallJob::band(grid), field.distance()); };
    job.measure(
        cost, [&] { return seconds_of(compute); },
        [&] {
            transform = std::make_unique<DistanceTransform>(job.device, job.mesh);
            return seconds_of(compute);
        });
    judge.look_at(field, job.options.samples_judged, cost);
    return cost;
}

/// The cost of more outputs, in a band of 10% on 256 samples a side: from the mesh's arrays, or on a kept transform.
CallCost measure_outputs(const CallJob& job, CallJudge& judge, bool is_kept) {
    const char* const what =
        "distance, offset to the closest point and gradient / the distance; a band of 10% on 256 samples on the "
        "longest side";
    CallCost cost{is_kept ? "outputs_again" : "outputs",
                  std::string(what) + (is_kept ? ", on a kept transform" : ", from the mesh's arrays")};
    if (!is_kept) cost.limit = 1.5;
    const Band wide = Band::symmetric(0.1 * job.mesh.box().longest_side());
    const Grid grid = Grid::around(job.mesh, job.scaled(256), wide);
    const DistanceTransform kept = job.transform();
    FieldWithOutputs outputs{kept.compute(grid, wide), {}, {}};
    Field alone = outputs.field;
    outputs.offset.resize(3 * grid.sample_count());
    outputs.gradient.resize(3 * grid.sample_count());
    const auto compute = [&](const OutputTargets& targets) {
        return seconds_of([&] {
            if (is_kept)
                kept.compute(grid, wide, targets);
            else
                job.transform().compute(grid, wide, targets);
        });
    };
    job.measure(
        cost, [&] { return compute(outputs.targets()); }, [&] { return compute(alone.distance()); });
    judge.look_at(outputs, job.options.samples_judged, cost);
    return cost;
}

/// Queries of one point, as a robot or a loop in Python asks them.
CallCost measure_one_point(const CallJob& job, CallJudge& judge, bool has_all_outputs) {
    CallCost cost{has_all_outputs ? "one_point_all_outputs" : "one_point",
                  fmt::format("a query of one point {}, a million of them (its ratio is the microseconds of one) / a "
                              "second",
                              has_all_outputs ? "with all outputs" : "for its distance")};
    cost.limit = has_all_outputs ? 40 : 20;
    const std::vector<Vec3> points = points_around(job.mesh, job.is_quick ? 1'000 : 20'000, job.options.seed);
    Field field;
    for (const OutputInfo& info : output_table()) field.resize(info.output, 1);
    std::vector<float> distance(points.size());
    const DistanceTransform transform = job.transform();
    const auto query = [&](std::size_t i) {
        OutputTargets targets = std::span(distance).subspan(i, 1);
        if (has_all_outputs) {
            targets = field.targets();
            targets[Output::distance] = std::span(distance).subspan(i, 1);
        }
        transform.query(std::span(points).subspan(i, 1), std::numeric_limits<double>::infinity(), targets);
    };
    query(0);  // builds the tree
    job.measure(
        cost,
        [&] {
            return 1e6 / static_cast<double>(points.size()) * seconds_of([&] {
                       for (std::size_t i = 0; i < points.size(); ++i) query(i);
                   });
        },
        [] { return 1.0; });
    judge.look_at(points, distance, job.mesh.box().longest_side() / 256, job.options.samples_judged, cost);
    return cost;
}

CallCost measure_small_meshes(const CallJob& job) {
    CallCost cost{"small_meshes", "1000 transforms of 512 triangles, 32 samples a side each / one field of 256 a side"};
    const Mesh small = make_shape("sphere3");
    const Band band = Band::symmetric(0.2);
    const Grid grid = Grid::around(small, 32, band);
    const Grid large = job.grid(256);
    Field field = DistanceTransform(job.device, small).compute(grid, band);
    Field whole = job.transform().compute(large, CallJob::band(large));
    job.measure(
        cost,
        [&] {
            return seconds_of([&] {
                for (int n = 0; n < (job.is_quick ? 100 : 1000); ++n)
                    DistanceTransform(job.device, small).compute(grid, band, field.distance());
            });
        },
        [&] { return seconds_of([&] { job.transform().compute(large, CallJob::band(large), whole.distance()); }); });
    CallJudge(small, job.options.seed).look_at(field, job.options.samples_judged, cost);
    return cost;
}

}  // namespace

std::vector<CallCost> measure_calls(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                    bool is_quick) {
    const CallJob job{mesh, device, options, is_quick};
    CallJudge judge(mesh, options.seed);
    return {measure_again(job, judge),
            measure_outputs(job, judge, false),
            measure_outputs(job, judge, true),
            measure_one_sample(job, judge),
            measure_one_point(job, judge, false),
            measure_one_point(job, judge, true),
            measure_patches(job, judge, false),
            measure_patches(job, judge, true),
            measure_band_boxes(job, judge),
            measure_moved(job, "moved", 256),
            measure_moved(job, "moved_128", 128),
            measure_moved_points(job),
            measure_step(job, false),
            measure_device_first(job, judge),
            measure_step(job, true),
            measure_classify(job, judge),
            measure_small_meshes(job)};
}

}  // namespace clsdf::bench

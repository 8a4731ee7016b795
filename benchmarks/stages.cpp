#include "benchmarks/stages.hpp"

#include <clsdf/tuning.hpp>

namespace clsdf::bench {

namespace {

TransformStatistics count(const Workload& workload, const Device& device) {
    TransformStatistics counted;
    DistanceTransform(device, workload.mesh).compute(workload.grid, workload.band, {}, {.count_work = true}, &counted);
    return counted;
}

}  // namespace

Stages measure_stages(const Workload& workload, const Device& device, const Floors& floors,
                      const MeasureOptions& options) {
    const Device profiled = with_profiling(device);
    Field field = DistanceTransform(profiled, workload.mesh).compute(workload.grid, workload.band);
    std::vector<double> whole, polyhedra, lists, sign, bricks, fill, transfer, rest;
    for (std::size_t n = 0; n < options.repetitions; ++n) {
        const DistanceTransform transform(profiled, workload.mesh);
        const CostWatch watch;
        const TransformStatistics s = transform.compute(workload.grid, workload.band, field.distance());
        const double seconds = watch.cost().wall;
        whole.push_back(seconds);
        polyhedra.push_back(s.polyhedra_seconds);
        lists.push_back(s.work->lists_seconds - s.work->sign_seconds);
        sign.push_back(s.work->sign_seconds);
        bricks.push_back(s.work->bricks_seconds);
        fill.push_back(s.work->fill_seconds);
        transfer.push_back(s.field_seconds - s.work->bricks_seconds - s.work->fill_seconds);
        rest.push_back(seconds - s.polyhedra_seconds - s.work->lists_seconds - s.field_seconds);
    }
    const auto median = [](const std::vector<double>& values) { return spread_of(values).median; };
    Stages stages;
    stages.whole = spread_of(whole);
    stages.polyhedra = median(polyhedra);
    stages.lists = median(lists);
    stages.sign = median(sign);
    stages.bricks = median(bricks);
    stages.fill = median(fill);
    stages.transfer = median(transfer);
    stages.rest = median(rest);
    stages.counts = count(workload, device);
    stages.judgement = Truth(workload, options.samples_judged, options.seed).judge(field.distance(), false, 1);
    stages.store_floor = static_cast<double>(workload.grid.sample_count() * sizeof(float)) / floors.best_store();
    stages.evaluation_floor =
        static_cast<double>(workload.list.samples.size()) * operations_of_a_distance / floors.fma_per_second;
    return stages;
}

}  // namespace clsdf::bench

#include "acceptance/cost.hpp"

#include <clsdf/distance_transform.hpp>
#include <clsdf/tuning.hpp>

namespace clsdf::acceptance {

std::vector<CostLimit> bunny_costs(const Device& device, const Problem& bunny) {
    TransformStatistics statistics;
    DistanceTransform(device, bunny.mesh, {.sign = bunny.sign})
        .compute(bunny.grid, bunny.band, Output::distance, {.count_work = true}, &statistics);
    const WorkCounts& work = *statistics.work;
    const auto per_band_sample = [&](std::size_t count) {
        return static_cast<double>(count) / static_cast<double>(work.band_samples);
    };
    const double boxes = static_cast<double>(work.box_polyhedra) / static_cast<double>(work.triangles);
    return {{"samples inside polyhedra per band sample", per_band_sample(work.samples_covered), 1, 2.2},
            {"lanes evaluated per band sample", per_band_sample(work.lanes_evaluated), 1, 30},
            // The exact gap test finds 46 on this mesh. A few more are conservative, many more are waste.
            {"point sites", static_cast<double>(work.point_sites), 40, 52},
            {"boxes, % of the triangles", 100 * boxes, 0, 0.1}};
}

}  // namespace clsdf::acceptance

#include "acceptance/cost.hpp"

#include <clsdf/distance_transform.hpp>

namespace clsdf::acceptance {

std::vector<CostLimit> bunny_costs(const Device& device, const Problem& bunny) {
    TransformStatistics statistics;
    DistanceTransform(device, bunny.mesh, {.sign = bunny.sign})(bunny.grid, bunny.band, {},
                                                                {.count = true, .statistics = &statistics});
    const auto per_band_sample = [&](std::size_t count) {
        return static_cast<double>(count) / static_cast<double>(statistics.band_samples);
    };
    const double boxes = static_cast<double>(statistics.box_polyhedra) / static_cast<double>(statistics.triangles);
    return {{"samples inside polyhedra per band sample", per_band_sample(statistics.samples_covered), 1, 2.2},
            {"lanes evaluated per band sample", per_band_sample(statistics.lanes_evaluated), 1, 30},
            // The exact gap test finds 46 on this mesh. A few more are conservative, many more are waste.
            {"point sites", static_cast<double>(statistics.point_sites), 40, 52},
            {"boxes, % of the triangles", 100 * boxes, 0, 0.1}};
}

}  // namespace clsdf::acceptance

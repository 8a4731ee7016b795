#include "true_samples.hpp"

#include <clsdf/reference.hpp>

#include <oneapi/tbb/parallel_for.h>

namespace clsdf::reference {

Field reference_field(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign) {
    band.validate();
    grid.validate();
    const TrueSamples truth(mesh, grid, sign, band.widest());

    Field field{grid, band, truth.sign(), mesh.name(), {}, {}};
    field.distance.resize(grid.sample_count());
    field.triangle.resize(grid.sample_count());
    oneapi::tbb::parallel_for(std::int64_t{0}, grid.size[2], [&](std::int64_t k) {
        std::vector<TrueSample> samples;
        for (std::int64_t j = 0; j < grid.size[1]; ++j) {
            truth.row(j, k, samples);
            for (std::size_t i = 0; i < samples.size(); ++i) {
                const TrueSample& sample = samples[i];
                const double width = half_width(band, truth.is_signed(), sample.inside);
                const bool in_band = sample.distance <= width;
                const double magnitude = in_band ? sample.distance : width;
                const auto value = static_cast<float>(sample.inside ? -magnitude : magnitude);
                const std::size_t offset = grid.offset(static_cast<std::int64_t>(i), j, k);
                field.distance[offset] = in_band && value == 0 ? 0.0F : value;
                field.triangle[offset] = in_band ? sample.triangle : no_triangle;
            }
        }
    });
    return field;
}

}  // namespace clsdf::reference

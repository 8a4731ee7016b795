#include "output_contracts.hpp"

#include <clsdf/reference.hpp>

#include "core/outputs.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <span>

namespace clsdf::reference {

Field reference_field(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign,
                      std::optional<double> floor) {
    band.validate();
    grid.validate();
    const TrueSamples truth(mesh, grid, sign, floor, band.widest());

    const MeshSites sites(mesh, truth.sign_surface());
    OutputSet outputs;
    for (const OutputInfo& info : output_table()) outputs.insert(info.output);
    Field field(
        FieldDescription{.grid = grid, .band = band, .sign = truth.sign(), .mesh_name = mesh.name(), .floor = floor},
        outputs);
    const std::span<float> distances = field.distance();
    for (const OutputInfo& info : extra_outputs()) std::ranges::fill(field.bytes(info.output), std::byte{0xFF});
    for_each_index(
        static_cast<std::size_t>(grid.size[2]),
        [&](std::size_t slice) {
            const auto k = static_cast<std::int64_t>(slice);
            std::vector<TrueSample> samples;
            for (std::int64_t j = 0; j < grid.size[1]; ++j) {
                truth.row(j, k, samples);
                for (std::size_t i = 0; i < samples.size(); ++i) {
                    const TrueSample& sample = samples[i];
                    const Index3 index{static_cast<std::int64_t>(i), j, k};
                    const double width = half_width(band, truth.is_signed(), sample.inside);
                    const bool in_band = sample.distance <= width;
                    const double magnitude = in_band ? sample.distance : width;
                    const auto value = static_cast<float>(sample.inside ? -magnitude : magnitude);
                    const std::size_t offset = grid.offset(index[0], j, k);
                    distances[offset] = in_band && value == 0 ? 0.0F : value;
                    if (in_band) store_outputs({truth, sites, sample, index}, field, offset);
                }
            }
        },
        1);
    return field;
}

}  // namespace clsdf::reference

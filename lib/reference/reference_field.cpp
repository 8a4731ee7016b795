#include "mesh_sites.hpp"
#include "true_samples.hpp"

#include <clsdf/reference.hpp>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace clsdf::reference {

namespace {

/// Of the signed distance; of a sample on the surface the pseudonormal, which faces without area do not have.
std::optional<Vec3> gradient_at(const TrueSamples& truth, const MeshSites& sites, const TrueSample& sample,
                                const Index3& index) {
    Vec3 gradient{};
    if (sample.distance > 0) {
        const ExactPosition position = truth.position(index);
        for (std::size_t axis = 0; axis < 3; ++axis)
            gradient[axis] = (position.head[axis] - sample.point[axis]) + position.tail[axis];
        const double length = std::hypot(gradient[0], gradient[1], gradient[2]);
        for (double& component : gradient) component *= (sample.inside ? -1 : 1) / length;
        return gradient;
    }
    std::optional<Vec3> normal = sites.pseudonormal(sample.triangle, sample.site);
    if (normal && truth.is_signed() && sites.is_inside_out())
        for (double& component : *normal) component = -component;
    return normal;
}

}  // namespace

Field reference_field(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign) {
    band.validate();
    grid.validate();
    const TrueSamples truth(mesh, grid, sign, band.widest());

    const MeshSites sites(mesh);
    Field field;
    field.grid = grid;
    field.band = band;
    field.sign = truth.sign();
    field.mesh_name = mesh.name();
    const std::size_t count = grid.sample_count();
    field.distance.resize(count);
    field.triangle.resize(count, no_triangle);
    field.site.resize(count, no_site);
    field.closest.resize(3 * count, std::numeric_limits<double>::quiet_NaN());
    field.gradient.resize(3 * count, std::numeric_limits<float>::quiet_NaN());
    oneapi::tbb::parallel_for(std::int64_t{0}, grid.size[2], [&](std::int64_t k) {
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
                field.distance[offset] = in_band && value == 0 ? 0.0F : value;
                if (!in_band) continue;
                field.triangle[offset] = sample.triangle;
                field.site[offset] = static_cast<std::uint8_t>(sample.site);
                std::copy(sample.point.begin(), sample.point.end(), &field.closest[3 * offset]);
                const std::optional<Vec3> gradient = gradient_at(truth, sites, sample, index);
                for (std::size_t axis = 0; gradient && axis < 3; ++axis)
                    field.gradient[3 * offset + axis] = static_cast<float>((*gradient)[axis]);
            }
        }
    });
    return field;
}

}  // namespace clsdf::reference

#include "mesh_sites.hpp"
#include "true_samples.hpp"

#include <clsdf/reference.hpp>

#include <oneapi/tbb/parallel_for.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

namespace clsdf::reference {

namespace {

/// The gradient of the signed distance. On the surface it is the pseudonormal; NaN if all faces there have no area.
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

/// Barycentric coordinates of the closest point on its triangle, by the areas that it spans with two vertices.
std::array<double, 3> weights_of(const MeshSites& sites, const TrueSample& sample) {
    const auto number = static_cast<std::size_t>(sample.site);
    std::array<double, 3> weights{};
    if (number < 3) {
        weights[number] = 1;
        return weights;
    }
    using Wide = Eigen::Matrix<long double, 3, 1>;
    std::array<Wide, 3> to_corners;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 corner = sites.corners(sample.triangle, Site::face).positions[k];
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            to_corners[k][axis] = static_cast<long double>(corner[a]) - static_cast<long double>(sample.point[a]);
        }
    }
    if (number < 6) {
        const std::size_t from = number - 3, to = (number - 2) % 3;
        const Wide along = to_corners[to] - to_corners[from];
        const long double way = along.squaredNorm() > 0 ? -to_corners[from].dot(along) / along.squaredNorm() : 0;
        weights[to] = static_cast<double>(way);
        weights[from] = static_cast<double>(1 - way);
        return weights;
    }
    const Wide normal = (to_corners[1] - to_corners[0]).cross(to_corners[2] - to_corners[0]);
    for (std::size_t k = 0; k < 3; ++k)
        weights[k] = static_cast<double>(to_corners[(k + 1) % 3].cross(to_corners[(k + 2) % 3]).dot(normal) /
                                         normal.squaredNorm());
    return weights;
}

}  // namespace

Field reference_field(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign) {
    band.validate();
    grid.validate();
    const TrueSamples truth(mesh, grid, sign, band.widest());

    const MeshSites sites(mesh);
    OutputSet outputs;
    for (const OutputInfo& info : output_table()) outputs.insert(info.output);
    Field field(FieldDescription{grid, band, truth.sign(), mesh.name()}, outputs);
    const std::span<float> distances = field.distance(), gradients = field.gradient(), weights = field.barycentric();
    const std::span<std::uint32_t> triangles = field.triangle();
    const std::span<std::uint8_t> site_numbers = field.site();
    const std::span<double> closest = field.closest();
    std::ranges::fill(triangles, no_triangle);
    std::ranges::fill(site_numbers, no_site);
    std::ranges::fill(closest, std::numeric_limits<double>::quiet_NaN());
    std::ranges::fill(weights, std::numeric_limits<float>::quiet_NaN());
    std::ranges::fill(gradients, std::numeric_limits<float>::quiet_NaN());
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
                distances[offset] = in_band && value == 0 ? 0.0F : value;
                if (!in_band) continue;
                triangles[offset] = sample.triangle;
                site_numbers[offset] = static_cast<std::uint8_t>(sample.site);
                const std::array<double, 3> corner_weights = weights_of(sites, sample);
                std::copy(corner_weights.begin() + 1, corner_weights.end(), &weights[2 * offset]);
                std::ranges::copy(sample.point, &closest[3 * offset]);
                const std::optional<Vec3> gradient = gradient_at(truth, sites, sample, index);
                for (std::size_t axis = 0; gradient && axis < 3; ++axis)
                    gradients[3 * offset + axis] = static_cast<float>((*gradient)[axis]);
            }
        }
    });
    return field;
}

}  // namespace clsdf::reference

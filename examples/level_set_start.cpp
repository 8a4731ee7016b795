// The start of a level set method: the signed distance, its gradient and the closest point in a narrow band, from one
// call. The distance is exact, so no reinitialisation is needed, and velocities of the surface are extended along the
// normals by looking them up at the closest point.
//
// example_level_set_start [RESOLUTION]

#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

using clsdf::Output;
using clsdf::Vec3;

/// The velocity that a simulation has on the surface: here of a body that turns around z.
Vec3 surface_velocity(const Vec3& p) {
    return {-p[1], p[0], 0};
}

struct LevelSet {
    clsdf::Grid grid;
    clsdf::Band band;
    std::vector<float> phi, normal;
    std::vector<double> closest;

    explicit LevelSet(const clsdf::Grid& grid_in, const clsdf::Band& band_in)
        : grid(grid_in),
          band(band_in),
          phi(grid.sample_count()),
          normal(3 * grid.sample_count()),
          closest(3 * grid.sample_count()) {}

    bool is_in_band(std::size_t sample) const { return !std::isnan(closest[3 * sample]); }
    Vec3 closest_point(std::size_t sample) const {
        return {closest[3 * sample], closest[3 * sample + 1], closest[3 * sample + 2]};
    }
};

/// The largest distance, in voxels, between the closest point and the point that phi and the normal lead to.
double largest_gap(const LevelSet& set) {
    double largest = 0;
    for (std::int64_t k = 0; k < set.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < set.grid.size[1]; ++j)
            for (std::int64_t i = 0; i < set.grid.size[0]; ++i) {
                const std::size_t n = set.grid.offset(i, j, k);
                if (!set.is_in_band(n)) continue;
                const Vec3 position = set.grid.position(i, j, k), closest = set.closest_point(n);
                double squared = 0;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double step = static_cast<double>(set.phi[n]) * static_cast<double>(set.normal[3 * n + axis]);
                    squared += std::pow(position[axis] - step - closest[axis], 2);
                }
                largest = std::max(largest, std::sqrt(squared) / set.grid.voxel());
            }
    return largest;
}

/// The speed along the normal at each sample of the band, extended from the surface; 0 elsewhere.
std::vector<float> extended_speed(const LevelSet& set) {
    std::vector<float> speed(set.phi.size());
    for (std::size_t n = 0; n < speed.size(); ++n) {
        if (!set.is_in_band(n)) continue;
        const Vec3 velocity = surface_velocity(set.closest_point(n));
        for (std::size_t axis = 0; axis < 3; ++axis)
            speed[n] += static_cast<float>(velocity[axis]) * set.normal[3 * n + axis];
    }
    return speed;
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        const std::int64_t resolution = argument_count > 1 ? std::atoll(arguments[1]) : 96;
        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        clsdf::GridOptions options;
        options.resolution = resolution;
        options.margin = clsdf::Length::in_voxels(4);
        const clsdf::Grid grid = clsdf::Grid::around(mesh.box(), options);
        LevelSet set(grid, clsdf::Band::symmetric(4 * grid.voxel()));

        const clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
        transform.compute(
            set.grid, set.band,
            {{Output::distance, set.phi}, {Output::closest, set.closest}, {Output::gradient, set.normal}});

        record(set.phi);
        record(set.closest);
        record(set.normal);

        const std::vector<float> speed = extended_speed(set);
        const auto fastest = std::ranges::max(speed);
        std::size_t in_band = 0;
        for (std::size_t n = 0; n < set.phi.size(); ++n) in_band += set.is_in_band(n) ? 1U : 0U;
        const double gap = largest_gap(set);
        std::printf("%zu of %zu samples in the band; the largest speed along the normal is %.3f\n", in_band,
                    set.phi.size(), static_cast<double>(fastest));
        std::printf("position - phi * normal is the closest point within %.1e voxel\n", gap);
        return in_band > 0 && fastest > 0 && gap < 1e-4 ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}

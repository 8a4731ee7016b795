// A solid that moves through a fixed grid: 100 steps of a rigid motion, each with a new field in the simulation's
// memory. A motion is always that of the first positions, so no error adds up: a body that comes back to its first
// place has its first field, byte for byte.
//
// example_moving_body [STEPS [RESOLUTION]]

#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

namespace {

using clsdf::Vec3;

struct Motion {
    std::array<Vec3, 3> rotation;
    Vec3 translation;
};

/// Once around z, and along x and back.
Motion motion_at(double part) {
    const double angle = 2 * std::numbers::pi * part, c = std::cos(angle), s = std::sin(angle);
    return {{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {0.2 * s, 0, 0}};
}

/// The volume inside: a cell that the surface crosses counts by its part, which the distance tells to first order.
double volume(const clsdf::Grid& grid, const std::vector<float>& distance) {
    double cells = 0;
    for (const float d : distance) cells += std::clamp(0.5 - static_cast<double>(d) / grid.voxel(), 0.0, 1.0);
    return cells * grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        const int steps = argument_count > 1 ? std::atoi(arguments[1]) : 100;
        const std::int64_t resolution = argument_count > 2 ? std::atoll(arguments[2]) : 64;
        const clsdf::Mesh mesh = clsdf::make_shape("knot");

        // The simulation's grid, which has room for all places of the body.
        const double reach = 0.8 * mesh.box().longest_side();
        clsdf::GridOptions options;
        options.resolution = resolution;
        const clsdf::Grid grid =
            clsdf::Grid::around(clsdf::Box{{-reach, -reach, -reach}, {reach, reach, reach}}, options);
        const clsdf::Band band = clsdf::Band::symmetric(3 * grid.voxel());
        std::vector<float> distance(grid.sample_count());

        clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
        transform.compute(grid, band, distance);
        const std::vector<float> first = distance;
        const double first_volume = volume(grid, distance);
        double largest_change = 0;
        for (int step = 1; step <= steps; ++step) {
            const Motion motion = motion_at(static_cast<double>(step) / steps);
            transform.set_motion(motion.rotation, motion.translation);
            transform.compute(grid, band, distance);
            if (step % 25 == 0) record(distance);
            largest_change = std::max(largest_change, std::abs(volume(grid, distance) / first_volume - 1));
        }
        const clsdf::KeptMemory memory = transform.memory();

        transform.set_motion({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 0});
        transform.compute(grid, band, distance);
        const bool is_as_before = distance == first;
        std::printf("%d steps: the volume changes by at most %.2f%%; %.1f MB kept on the host, %.1f MB on the device\n",
                    steps, 100 * largest_change, 1e-6 * static_cast<double>(memory.host_bytes),
                    1e-6 * static_cast<double>(memory.device_bytes));
        std::printf("back at its first place, the body has %s field\n", is_as_before ? "its first" : "ANOTHER");
        return is_as_before && largest_change < 0.02 ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}

// A rotor turns in its stator. Each step computes a field of both, in which a mask of cells or a level set would begin:
// the distance to the nearer wall, and which of the two it is.
//
// example_rotor_and_stator [STEPS [RESOLUTION]]

#include <clsdf/clsdf.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

using clsdf::Band;
using clsdf::Field;
using clsdf::Grid;
using clsdf::Output;
using clsdf::Pose;
using clsdf::Vec3;

constexpr double pi = 3.14159265358979323846;

/// A closed ring of blocks around the z axis: inner and outer radius by the angle, from z = -1 to 1.
template <typename Radii>
clsdf::Mesh ring(std::uint32_t count, const Radii& radii) {
    std::vector<Vec3> vertices;
    std::vector<clsdf::Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * pi * i / count;
        const std::array<double, 2> r = radii(i);
        for (const double radius : r)
            for (const double z : {-1.0, 1.0})
                vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
        // Inner below and above, outer below and above, here and at the next angle.
        const std::uint32_t a = 4 * i, b = 4 * ((i + 1) % count);
        const auto quad = [&](std::uint32_t p, std::uint32_t q, std::uint32_t s, std::uint32_t t) {
            triangles.push_back({p, q, s});
            triangles.push_back({p, s, t});
        };
        quad(a + 2, b + 2, b + 3, a + 3);  // outer
        quad(a, a + 1, b + 1, b);          // inner
        quad(a + 1, a + 3, b + 3, b + 1);  // above
        quad(a, b, b + 2, a + 2);          // below
    }
    return {vertices, triangles, "ring"};
}

}  // namespace

int main(int argc, char** argv) {
    const int steps = argc > 1 ? std::atoi(argv[1]) : 4;
    const long resolution = argc > 2 ? std::atol(argv[2]) : 96;
    // A rotor with six teeth and a shaft hole, and the stator around it.
    const clsdf::Mesh rotor = ring(48, [](std::uint32_t i) { return std::array{0.3, i % 8 < 4 ? 0.9 : 0.6}; });
    const clsdf::Mesh stator = ring(64, [](std::uint32_t) { return std::array{1.0, 1.2}; });

    clsdf::Scene scene(clsdf::Device::automatic());
    const std::uint32_t turning = scene.add(rotor);
    scene.add(stator);
    const Grid grid = Grid::around(scene.box(), {.resolution = resolution});
    const Band band = Band::symmetric(3 * grid.voxel());
    double seconds = 0;
    bool is_right = true;
    for (int step = 0; step < steps; ++step) {
        const double angle = 0.05 * step, c = std::cos(angle), s = std::sin(angle);
        const std::array pose{Pose{{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {}}};
        const auto begin = std::chrono::steady_clock::now();
        scene.set_poses(std::array{turning}, pose);
        const Field field = scene.compute(grid, band, Output::body | Output::gradient);
        seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        std::size_t of_rotor = 0, of_stator = 0;
        for (std::size_t i = 0; i < grid.sample_count(); ++i) {
            of_rotor += field.body()[i] == turning ? 1U : 0U;
            of_stator += field.body()[i] == 1 - turning ? 1U : 0U;
            is_right =
                is_right && (field.body()[i] == clsdf::no_body) == (field.gradient()[3 * i] != field.gradient()[3 * i]);
        }
        std::printf("turned by %.2f: %zu samples near the rotor, %zu near the stator\n", angle, of_rotor, of_stator);
        is_right = is_right && of_rotor > 0 && of_stator > 0;
    }
    std::printf("%.1f ms a step\n", 1e3 * seconds / steps);
    return is_right ? EXIT_SUCCESS : EXIT_FAILURE;
}

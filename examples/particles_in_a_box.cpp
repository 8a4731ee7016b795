// Particles of three shapes in a box. Each shape is prepared once, whatever the number of particles. One call finds the
// nearest particle of many points, another one the field of a part of the box.
//
// example_particles_in_a_box [PARTICLES [POINTS]]

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

namespace {

using clsdf::Band;
using clsdf::Field;
using clsdf::Grid;
using clsdf::Output;
using clsdf::Pose;
using clsdf::Vec3;

/// A rotation by Shoemake's quaternions, and a place.
Pose random_pose(const Vec3& place, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform;
    const double u = uniform(random), a = 6.283185307179586 * uniform(random), b = 6.283185307179586 * uniform(random);
    const double x = std::sqrt(1 - u) * std::sin(a), y = std::sqrt(1 - u) * std::cos(a), z = std::sqrt(u) * std::sin(b),
                 w = std::sqrt(u) * std::cos(b);
    return {{{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
              {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
              {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}},
            place};
}

}  // namespace

int main(int argc, char** argv) {
    const auto argument = [&](int number, std::size_t usual) {
        return argc > number ? static_cast<std::size_t>(std::atol(argv[number])) : usual;
    };
    const std::size_t count = argument(1, 10000), point_count = argument(2, 20000);
    // One particle a cell of a lattice, so that few overlap.
    const auto cells = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(count))));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> shift(-0.3, 0.3);

    clsdf::Scene scene(clsdf::Device::automatic());
    std::array<std::uint32_t, 3> shapes{};
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < count; ++i) {
        if (i < shapes.size()) {
            // Shapes of the size 1 or 2 in cells of the size 3.
            shapes[i] = scene.add(clsdf::make_shape(std::array{"sphere2", "cube", "torus"}[i]));
        } else {
            scene.add_instance(shapes[i % shapes.size()]);
        }
        const Vec3 cell{static_cast<double>(i % cells), static_cast<double>(i / cells % cells),
                        static_cast<double>(i / cells / cells)};
        poses.push_back(random_pose(
            {3 * (cell[0] + shift(random)), 3 * (cell[1] + shift(random)), 3 * (cell[2] + shift(random))}, random));
    }
    scene.set_poses(poses);

    std::uniform_real_distribution<double> anywhere(0, 3 * static_cast<double>(cells));
    std::vector<Vec3> points(point_count), closest(point_count);
    for (Vec3& p : points) p = {anywhere(random), anywhere(random), anywhere(random)};
    std::vector<double> distance(point_count);
    std::vector<std::uint32_t> body(point_count);
    const auto begin = std::chrono::steady_clock::now();
    scene.query(points, 1.0, {{{Output::distance, distance}, {Output::closest, closest}, {Output::body, body}}});
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::size_t near = 0, inside = 0, wrong = 0;
    for (std::size_t i = 0; i < point_count; ++i) {
        inside += distance[i] < 0 ? 1U : 0U;
        if (body[i] == clsdf::no_body) continue;
        ++near;
        const double to_closest =
            std::hypot(points[i][0] - closest[i][0], points[i][1] - closest[i][1], points[i][2] - closest[i][2]);
        wrong += std::abs(std::abs(distance[i]) - to_closest) > 1e-9 ? 1U : 0U;
    }
    std::printf("%zu particles, %zu points: %zu within 1 of a particle, %zu in one; %.1f ms\n", count, point_count,
                near, inside, 1e3 * seconds);

    // A part of the box: only the particles that reach it are computed.
    const Grid grid = Grid::between({0, 0, 0}, {6, 6, 6}, {.cells = 48});
    const Field field = scene.compute(grid, Band::symmetric(3 * grid.voxel()), Output::body);
    std::size_t in_particles = 0;
    for (const float value : field.distance()) in_particles += value < 0 ? 1U : 0U;
    std::printf("%.1f%% of a corner of the box is filled\n",
                100.0 * static_cast<double>(in_particles) / static_cast<double>(grid.sample_count()));
    return near > 0 && inside > 0 && wrong == 0 && in_particles > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

// The time of fields of many small bodies: 1,000 spheres of 512 faces, each a mesh of its own or all instances of one.
//
// * made, and the field of a grid in which each has a cell of 32^3 samples; beside it the same by a transform and a
// call
//   for each cell;
// * a field of 256^3 of all, 3 voxels on both sides, with new poses in each step.
//
// Prints a line for each case: the median of wall-clock and processor time, in milliseconds, and how many samples of
// some bodies' cells differ by a bit from the field of the body's own transform.
//
// benchmark_scene_fields [REPETITIONS]
#include "benchmarks/cost.hpp"
#include "benchmarks/measure.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>
#include <span>
#include <vector>

namespace {

using clsdf::Band;
using clsdf::DistanceTransform;
using clsdf::Grid;
using clsdf::Index3;
using clsdf::Mesh;
using clsdf::Output;
using clsdf::Pose;
using clsdf::Scene;
using clsdf::Vec3;
using clsdf::bench::Cost;
using clsdf::bench::CostWatch;

constexpr std::int64_t cells = 10;  // along each axis
constexpr std::size_t bodies = cells * cells * cells;

Index3 cell_of(std::size_t body) {
    const auto number = static_cast<std::int64_t>(body);
    return {number % cells, number / cells % cells, number / cells / cells};
}

/// A body in each cell, with the side 1, of `samples` samples a side, at most 0.02 beside its centre, so that no sample
/// of another cell is in its band, and turned about z.
std::vector<Pose> poses_of(std::size_t step) {
    std::mt19937 random(static_cast<std::mt19937::result_type>(step));
    std::uniform_real_distribution<double> aside(-0.02, 0.02), angle(0, 6.28);
    std::vector<Pose> poses(bodies);
    for (std::size_t i = 0; i < bodies; ++i) {
        const double c = std::cos(angle(random)), s = std::sqrt(1 - c * c);
        poses[i].rotation = {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
        for (std::size_t axis = 0; axis < 3; ++axis)
            poses[i].translation[axis] = static_cast<double>(cell_of(i)[axis]) + 0.5 + aside(random);
    }
    return poses;
}

/// A sphere of 512 faces with the radius 0.35.
Mesh small_mesh() {
    const Mesh sphere = clsdf::make_shape("sphere3");
    const double radius = sphere.box().longest_side() / 2;
    std::vector<Vec3> vertices(sphere.vertices().begin(), sphere.vertices().end());
    for (Vec3& p : vertices)
        for (double& x : p) x *= 0.35 / radius;
    return {std::move(vertices), {sphere.triangles().begin(), sphere.triangles().end()}, "sphere"};
}

Grid grid_of(std::int64_t samples) {
    const double spacing = static_cast<double>(cells) / static_cast<double>(samples);
    return {{spacing / 2, spacing / 2, spacing / 2}, {spacing, spacing, spacing}, {samples, samples, samples}, {}};
}

Grid cell(const Grid& grid, std::size_t body) {
    Index3 first = cell_of(body), size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t end = (first[axis] + 1) * grid.size[axis] / cells;
        first[axis] = first[axis] * grid.size[axis] / cells;
        size[axis] = end - first[axis];
    }
    return grid.part(first, size);
}

std::size_t differences(const Mesh& mesh, const std::vector<Pose>& poses, const Grid& grid, const Band& band,
                        const std::vector<float>& distance) {
    DistanceTransform transform(clsdf::Device::automatic(), mesh);
    std::size_t count = 0;
    for (std::size_t body = 0; body < bodies; body += 37) {
        transform.set_motion(poses[body].rotation, poses[body].translation);
        const Grid part = cell(grid, body);
        const clsdf::Field field = transform.compute(part, band);
        for (std::int64_t z = 0; z < part.size[2]; ++z)
            for (std::int64_t y = 0; y < part.size[1]; ++y)
                for (std::int64_t x = 0; x < part.size[0]; ++x)
                    count +=
                        std::memcmp(&field.distance()[part.offset(x, y, z)],
                                    &distance[grid.offset(part.first[0] + x, part.first[1] + y, part.first[2] + z)],
                                    sizeof(float)) != 0
                            ? 1U
                            : 0U;
    }
    return count;
}

/// Returns the number of differences.
std::size_t run(const char* name, std::size_t repetitions, const std::function<Cost(std::size_t)>& step,
                const std::function<std::size_t()>& judge) {
    std::vector<double> wall, processor;
    step(0);  // which prepares
    std::size_t wrong = judge();
    for (std::size_t i = 1; i <= repetitions; ++i) {
        const Cost cost = step(i);
        wall.push_back(1e3 * cost.wall);
        processor.push_back(1e3 * cost.processor);
    }
    wrong += judge();
    std::printf("%-44s %8.1f %8.1f %6zu\n", name, clsdf::bench::spread_of(wall).median,
                clsdf::bench::spread_of(processor).median, wrong);
    std::fflush(stdout);
    return wrong;
}

}  // namespace

int main(int argc, char** argv) {
    const std::size_t repetitions = argc > 1 ? static_cast<std::size_t>(std::max(1, std::atoi(argv[1]))) : 5;
    const clsdf::Device device = clsdf::Device::automatic();
    const Mesh mesh = small_mesh();
    const std::vector<Mesh> meshes(bodies, mesh);
    std::size_t wrong = 0;
    std::printf("%zu bodies, %zu faces each, %zu repetitions\n%-44s %8s %8s %6s\n", bodies, mesh.triangles().size(),
                repetitions, "", "ms", "core ms", "differ");

    const Grid in_cells = grid_of(32 * cells);
    const Band of_cells = Band::symmetric(2.7 * in_cells.voxel());
    std::vector<float> distance(in_cells.sample_count());
    const std::vector<Pose> poses = poses_of(0);
    const auto judge_cells = [&] { return differences(mesh, poses, in_cells, of_cells, distance); };
    run(
        "a transform and a call each, cells of 32^3", repetitions,
        [&](std::size_t) {
            std::vector<float> of_cell(32 * 32 * 32);
            const CostWatch watch;
            for (std::size_t i = 0; i < bodies; ++i) {
                DistanceTransform transform(device, meshes[i]);
                transform.set_motion(poses[i].rotation, poses[i].translation);
                transform.compute(cell(in_cells, i), of_cells, of_cell);
            }
            return watch.cost();
        },
        [] { return std::size_t{0}; });
    wrong += run(
        "a scene made, cells of 32^3", repetitions,
        [&](std::size_t) {
            const CostWatch watch;
            Scene scene(device);
            scene.add(meshes, poses);
            scene.compute(in_cells, of_cells, distance);
            return watch.cost();
        },
        judge_cells);
    wrong += run(
        "a scene of instances made, the same", repetitions,
        [&](std::size_t) {
            const CostWatch watch;
            Scene scene(device);
            scene.add(mesh, poses[0]);
            for (std::size_t i = 1; i < bodies; ++i) scene.add_instance(0, poses[i]);
            scene.compute(in_cells, of_cells, distance);
            return watch.cost();
        },
        judge_cells);
    run(
        "making the scene alone", repetitions,
        [&](std::size_t) {
            const CostWatch watch;
            Scene scene(device);
            scene.add(meshes, poses);
            return watch.cost();
        },
        [] { return std::size_t{0}; });

    const Grid all = grid_of(256);
    const Band of_all = Band::symmetric(3 * all.voxel());
    distance.resize(all.sample_count());
    Scene scene(device);
    scene.add(mesh);
    for (std::size_t i = 1; i < bodies; ++i) scene.add_instance(0);
    std::vector<Pose> moved;
    wrong += run(
        "instances, 256^3, new poses", repetitions,
        [&](std::size_t step) {
            moved = poses_of(step);
            const CostWatch watch;
            scene.set_poses(moved);
            scene.compute(all, of_all, distance);
            return watch.cost();
        },
        [&] { return differences(mesh, moved, all, of_all, distance); });
    return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

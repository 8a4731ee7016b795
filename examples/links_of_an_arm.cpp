// An arm of links moves. In each step one call gives the distance of every point near the arm, which link is nearest,
// and the direction away from it.
//
// example_links_of_an_arm [LINKS [POINTS [STEPS [TRIANGLES' SHAPE]]]]

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

namespace {

using clsdf::Output;
using clsdf::Pose;
using clsdf::Vec3;

/// The poses of links that stand on each other, each turned by `angle` against the one below.
std::vector<Pose> poses_of(std::size_t links, double length, double angle) {
    std::vector<Pose> poses(links);
    Vec3 at{};
    for (std::size_t i = 0; i < links; ++i) {
        const double all = angle * static_cast<double>(i), c = std::cos(all), s = std::sin(all);
        poses[i] = {{{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}}, at};
        at = {at[0] + s * length, at[1], at[2] + c * length};
    }
    return poses;
}

}  // namespace

int main(int argc, char** argv) {
    const auto argument = [&](int number, std::size_t usual) {
        return argc > number ? static_cast<std::size_t>(std::atol(argv[number])) : usual;
    };
    const std::size_t links = argument(1, 8), count = argument(2, 1000), steps = argument(3, 10);
    const clsdf::Mesh link = clsdf::make_shape(argc > 4 ? argv[4] : "sphere4");
    const double length = 2 * link.box().longest_side() / 3;

    const clsdf::Device device = clsdf::Device::automatic();
    clsdf::Scene scene(device);
    const std::uint32_t first = scene.add(link);
    for (std::size_t i = 1; i < links; ++i) scene.add_instance(first);  // which shares the mesh

    std::vector<Vec3> points(count);
    std::vector<float> distance(count);
    std::vector<Vec3> closest(count);
    std::vector<std::uint32_t> body(count);
    double seconds = 0, processor_seconds = 0, largest = 0;
    std::size_t near = 0;
    for (std::size_t step = 0; step < steps; ++step) {
        const std::vector<Pose> poses = poses_of(links, length, 0.02 * static_cast<double>(step));
        // Beside the links.
        for (std::size_t i = 0; i < count; ++i) {
            const double turn = 2.39996 * static_cast<double>(i), away = 0.55 * link.box().longest_side();
            const Vec3& at = poses[i % links].translation;
            points[i] = {at[0] + away * std::cos(turn), at[1] + away * std::sin(turn), at[2]};
        }
        const auto begin = std::chrono::steady_clock::now();
        const std::clock_t begin_of_processors = std::clock();
        scene.set_poses(poses);
        scene.query(points, length, {{{Output::distance, distance}, {Output::closest, closest}, {Output::body, body}}});
        if (step > 0) {
            seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
            processor_seconds += static_cast<double>(std::clock() - begin_of_processors) / CLOCKS_PER_SEC;
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (body[i] == clsdf::no_body) continue;
            const double to_closest =
                std::hypot(points[i][0] - closest[i][0], points[i][1] - closest[i][1], points[i][2] - closest[i][2]);
            largest = std::max(largest, std::abs(std::abs(static_cast<double>(distance[i])) - to_closest));
            ++near;
        }
    }
    // At rest: the union itself, whose depth is exact where links overlap, too.
    const clsdf::SceneSurface surface = scene.outer();
    const clsdf::DistanceTransform of_union(device, surface.surface.mesh);
    std::vector<float> depth(count);
    of_union.query(points, length, {{Output::distance, depth}});
    for (std::size_t i = 0; i < count; ++i)
        if (distance[i] > 0) largest = std::max(largest, static_cast<double>(std::abs(depth[i] - distance[i])));

    // The same without cutting faces, also for links that move.
    clsdf::Scene united(device, {.surface = clsdf::Surface::outer});
    united.add(link);
    for (std::size_t i = 1; i < links; ++i) united.add_instance(0);
    united.set_poses(poses_of(links, length, 0.02 * static_cast<double>(steps - 1)));
    std::vector<float> without_cuts(count);
    united.query(points, length, {{{Output::distance, without_cuts}}});
    for (std::size_t i = 0; i < count; ++i)
        largest = std::max(largest, static_cast<double>(std::abs(depth[i] - without_cuts[i])));

    const double of_steps = static_cast<double>(steps > 1 ? steps - 1 : 1);
    std::printf("%zu links of %zu triangles, %zu points: %zu have a link within %g in %zu steps\n", links,
                link.triangles().size(), count, near, length, steps);
    std::printf("the arm has %zu triangles without what lies in other links, and a volume of %g\n",
                surface.surface.mesh.triangles().size(), surface.surface.volume);
    std::printf("%.3f ms a step, %.3f ms of processor time\n", 1e3 * seconds / of_steps,
                1e3 * processor_seconds / of_steps);
    return near > 0 && largest < 1e-5 * length ? EXIT_SUCCESS : EXIT_FAILURE;
}

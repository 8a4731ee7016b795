// The time of a step of an arm: new poses of all links, and points among them. The links are ellipsoids of 2,048 faces,
// 0.1 wide and 0.3 long, each turned against the one before it by at most a radian. Neighbours overlap at the joints.
// Prints a line for each case: the median of wall-clock and processor time, in milliseconds, and how many of a hundred
// points of the first and the last step differ from the least of the links' own transforms, or from the cut union.
//
// benchmark_scenes [STEPS]
#include "benchmarks/cost.hpp"
#include "benchmarks/measure.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace {

using clsdf::Output;
using clsdf::Pose;
using clsdf::Vec3;

constexpr double between_joints = 0.26;
constexpr unsigned seed = 1;

struct Case {
    const char* name;
    std::size_t links, points;
    double half_width;
    bool are_instances;
    bool has_gradient;
    clsdf::Surface surface = clsdf::Surface::given;
};

clsdf::Mesh link_of_arm() {
    const clsdf::Mesh sphere = clsdf::make_shape("sphere4");
    const double radius = sphere.box().longest_side() / 2;
    std::vector<Vec3> vertices(sphere.vertices().begin(), sphere.vertices().end());
    for (auto& [x, y, z] : vertices) {
        x *= 0.05 / radius;
        y *= 0.05 / radius;
        z = z * 0.15 / radius + between_joints / 2;
    }
    return {std::move(vertices), {sphere.triangles().begin(), sphere.triangles().end()}, "link"};
}

Vec3 moved(const Pose& pose, const Vec3& p) {
    Vec3 result = pose.translation;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) result[a] += pose.rotation[a][b] * p[b];
    return result;
}

/// The joints turn about x and y in turns, back and forth.
std::vector<Pose> poses_of(std::size_t links, std::size_t step) {
    std::vector<Pose> poses(links);
    for (std::size_t i = 1; i < links; ++i) {
        const double angle = std::sin(0.05 * static_cast<double>(step) + 2.4 * static_cast<double>(i));
        const double c = std::cos(angle), s = std::sin(angle);
        const std::array<Vec3, 3> joint = i % 2 == 0 ? std::array<Vec3, 3>{{{1, 0, 0}, {0, c, -s}, {0, s, c}}}
                                                     : std::array<Vec3, 3>{{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}};
        poses[i].translation = moved(poses[i - 1], {0, 0, between_joints});
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b) {
                double& element = poses[i].rotation[a][b] = 0;
                for (std::size_t k = 0; k < 3; ++k) element += poses[i - 1].rotation[a][k] * joint[k][b];
            }
    }
    return poses;
}

/// Within 0.05 of the links' vertices.
std::vector<Vec3> points_beside(const clsdf::Mesh& link, const std::vector<Pose>& poses, std::size_t count,
                                std::mt19937& random) {
    std::uniform_real_distribution<double> part(-1, 1);
    std::vector<Vec3> points(count);
    for (Vec3& p : points) {
        Vec3 way{1, 1, 1};
        while (std::hypot(way[0], way[1], way[2]) > 1) way = {part(random), part(random), part(random)};
        p = moved(poses[random() % poses.size()], link.vertices()[random() % link.vertices().size()]);
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += 0.05 * way[axis];
    }
    return points;
}

int run(const Case& measured, std::size_t steps) {
    const clsdf::Device device = clsdf::Device::automatic();
    const clsdf::Mesh link = link_of_arm();
    clsdf::Scene scene(device, {.surface = measured.surface});
    for (std::size_t i = 0; i < measured.links; ++i)
        if (i > 0 && measured.are_instances)
            scene.add_instance(0);
        else
            scene.add(link);
    clsdf::DistanceTransform transform(device, link);
    std::mt19937 random(seed);
    std::vector<float> distance(measured.points);
    std::vector<std::array<float, 3>> gradient(measured.has_gradient ? measured.points : 0);
    std::vector<std::uint32_t> body(measured.points);
    clsdf::SceneTargets targets{{{Output::distance, distance}, {Output::body, body}}};
    if (measured.has_gradient) targets.outputs[Output::gradient] = gradient;
    std::vector<double> wall, processor;
    int wrong = 0;
    for (std::size_t step = 0; step < steps; ++step) {
        const std::vector<Pose> poses = poses_of(measured.links, step);
        const std::vector<Vec3> points = points_beside(link, poses, measured.points, random);
        const clsdf::bench::CostWatch watch;
        scene.set_poses(poses);
        scene.query(points, measured.half_width, targets);
        const clsdf::bench::Cost cost = watch.cost();
        if (step > 0) {  // the first one prepares
            wall.push_back(1e3 * cost.wall);
            processor.push_back(1e3 * cost.processor);
        }
        if (step > 0 && step + 1 < steps) continue;
        const std::size_t judged = std::min<std::size_t>(100, points.size());
        std::vector<double> least(judged, measured.half_width), of_link(judged);
        if (measured.surface == clsdf::Surface::outer) {
            const clsdf::DistanceTransform of_union(device, scene.outer().surface.mesh);
            of_union.query(std::span(points).first(judged), measured.half_width, least);
        }
        for (const Pose& pose : poses) {
            if (measured.surface == clsdf::Surface::outer) break;
            transform.set_motion(pose.rotation, pose.translation);
            transform.query(std::span(points).first(judged), measured.half_width, of_link);
            for (std::size_t i = 0; i < judged; ++i) least[i] = std::min(least[i], of_link[i]);
        }
        for (std::size_t i = 0; i < judged; ++i)
            wrong += std::abs(static_cast<double>(distance[i]) - least[i]) < 1e-6 ? 0 : 1;
    }
    std::printf("%-36s %8.3f %8.3f %6d\n", measured.name, clsdf::bench::spread_of(wall).median,
                clsdf::bench::spread_of(processor).median, wrong);
    return wrong;
}

}  // namespace

int main(int argc, char** argv) {
    const std::size_t steps = argc > 1 ? static_cast<std::size_t>(std::max(2, std::atoi(argv[1]))) : 200;
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    std::printf("seed %u, %zu steps\n%-36s %8s %8s %6s\n", seed, steps, "", "ms", "core ms", "wrong");
    int wrong = 0;
    for (const Case& measured :
         {Case{"20 links, 1,000 points, within 0.1", 20, 1000, 0.1, false, false},
          Case{"20 instances, the same", 20, 1000, 0.1, true, false},
          Case{"8 links, 5,000 points, gradient", 8, 5000, no_limit, false, true},
          Case{"1 link, 1,000 points", 1, 1000, no_limit, false, false},
          Case{"20 links, 1,000 points, their union", 20, 1000, 0.1, false, false, clsdf::Surface::outer},
          Case{"8 links, 5,000 points, their union", 8, 5000, no_limit, false, true, clsdf::Surface::outer}})
        wrong += run(measured, steps);
    return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

#pragma once

#include "support/queries.hpp"

#include <clsdf/clsdf.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

/// Scenes, and a transform for each of their bodies, moved by set_motion(), to hold them against.
namespace clsdf::test {

inline std::array<Vec3, 3> random_rotation(Random& random) {
    const Vec3 x = random.direction();
    Vec3 y{};
    for (double length = 0; length < 0.1;) {
        const Vec3 v = random.direction();
        y = {x[1] * v[2] - x[2] * v[1], x[2] * v[0] - x[0] * v[2], x[0] * v[1] - x[1] * v[0]};
        length = std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
        for (double& c : y) c /= length;
    }
    return {{x, y, {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]}}};
}

/// The values of points, in double.
struct PointValues {
    explicit PointValues(std::size_t count)
        : distance(count),
          closest(count),
          gradient(count),
          offset(count),
          triangle(count),
          body(count),
          is_own(count) {}

    SceneTargets targets() {
        return {{{Output::distance, distance},
                 {Output::closest, closest},
                 {Output::gradient, gradient},
                 {Output::offset, offset},
                 {Output::triangle, triangle},
                 {Output::body, body}},
                is_own};
    }

    std::vector<double> distance;
    std::vector<Vec3> closest, gradient, offset;
    std::vector<std::uint32_t> triangle, body;
    std::vector<std::uint8_t> is_own;
};

inline PointValues query(const Scene& scene, std::span<const Vec3> points, double half_width = no_limit) {
    PointValues values(points.size());
    scene.query(points, half_width, values.targets());
    return values;
}

inline std::vector<double> distances(const DistanceTransform& transform, std::span<const Vec3> points) {
    std::vector<double> result(points.size());
    transform.query(points, no_limit, result);
    return result;
}

struct BodyOfTest {
    const Mesh* mesh;
    SignRule sign;
    Pose pose;
};

/// Meshes of a few faces: closed ones, open ones, soups, a triangle, slivers.
inline std::vector<Mesh> meshes_of_bodies(Random& random) {
    std::vector<Mesh> meshes{cube(1), reversed(cube(0.3)), without_triangle(cube(1), 3), make_shape("sphere2")};
    meshes.push_back(random_closed(random, 2));
    meshes.push_back(random_soup(random, 6, 5));
    meshes.push_back(random_slivers(random, 5));
    meshes.push_back(Mesh(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 0.5, 0.2}}, {{0, 1, 2}}, "triangle"));
    return meshes;
}

/// Bodies, instances, overlaps and nesting, far apart or not, with mixed rules; points among them.
struct RandomScene {
    explicit RandomScene(std::uint64_t seed) : random(seed), meshes(meshes_of_bodies(random)) {
        const std::size_t count = seed % 100 == 0 ? 200 : seed % 10 == 0 ? 60 : 1 + random.index(8);
        const double apart = std::array{0.0, 0.5, 2.0, 30.0}[random.index(4)];
        const Vec3 all_at = random.index(4) == 0 ? random.point(-1e6, 1e6) : Vec3{};
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t number = random.index(meshes.size());
            const bool is_none = random.index(6) == 0;
            Pose pose;
            if (random.index(3) != 0) pose.rotation = random_rotation(random);
            if (random.index(5) != 0 || all_at != Vec3{})
                pose.translation = along(all_at, apart * random.uniform(0, 1), random.direction());
            const auto same = std::ranges::find_if(
                bodies, [&](const BodyOfTest& body) { return body.mesh == &meshes[number] && random.index(2) == 0; });
            const bool is_instance = same != bodies.end();
            const SignRule sign = is_instance ? same->sign : is_none ? SignRule::none : SignRule::automatic;
            if (is_instance)
                scene.add_instance(static_cast<std::uint32_t>(same - bodies.begin()), pose);
            else
                scene.add(meshes[number], pose, sign);
            pose = scene.pose(static_cast<std::uint32_t>(i));
            bodies.push_back({&meshes[number], sign, pose});
            transforms.emplace_back(test_device(), meshes[number], TransformOptions{.sign = sign});
            transforms.back().set_motion(pose.rotation, pose.translation);
        }
        for (int i = 0; i < 40; ++i) {
            const std::uint32_t body = random.index(count);
            const Mesh& mesh = *bodies[body].mesh;
            const Pose& pose = bodies[body].pose;
            const Vec3 p = along(mesh.vertices()[random.index(mesh.vertices().size())],
                                 std::array{0.0, 0.01, 0.3, 1.0, 50.0}[random.index(5)], random.direction());
            Vec3 moved = pose.translation;
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b < 3; ++b) moved[a] += pose.rotation[a][b] * p[b];
            points.push_back(i % 8 == 7 ? pose.translation : moved);
        }
        double largest = 1;
        for (const Vec3& p : points)
            for (const double x : p) largest = std::max(largest, std::abs(x));
        tolerance = 2e-14 * largest;
        for (const DistanceTransform& transform : transforms) of_bodies.push_back(distances(transform, points));
    }

    double least(std::size_t point) const {
        double result = of_bodies[0][point];
        for (const std::vector<double>& of_body : of_bodies) result = std::min(result, of_body[point]);
        return result;
    }

    Random random;
    std::vector<Mesh> meshes;
    Scene scene{test_device()};
    std::vector<BodyOfTest> bodies;
    std::vector<DistanceTransform> transforms;
    std::vector<Vec3> points;
    std::vector<std::vector<double>> of_bodies;
    double tolerance = 0;
};

}  // namespace clsdf::test

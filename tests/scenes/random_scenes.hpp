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
                 {Output::triangle, triangle}},
                body,
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

}  // namespace clsdf::test

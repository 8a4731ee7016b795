// The search of GPUs beside that of processors: both find the same pair of squared distance and triangle, so all
// results have the same bytes.
#include "support/deep_mesh.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

Vec3 corner(const Mesh& mesh, std::size_t triangle, std::size_t number) {
    return mesh.vertices()[mesh.triangles()[triangle][number]];
}

/// A point of the surface.
Vec3 on_triangle(const Mesh& mesh, std::size_t triangle, double w0, double w1) {
    Vec3 p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] = w0 * corner(mesh, triangle, 0)[axis] + w1 * corner(mesh, triangle, 1)[axis] +
                  (1 - w0 - w1) * corner(mesh, triangle, 2)[axis];
    return p;
}

/// Families of points that are hard to decide.
enum class Family { vertices, edges, faces, beside, around, far, denormal, centre };
constexpr std::array families{Family::vertices, Family::edges, Family::faces,    Family::beside,
                              Family::around,   Family::far,   Family::denormal, Family::centre};

Vec3 point_of(Family family, const Mesh& mesh, Random& random) {
    const double side = std::max(mesh.box().longest_side(), 1e-30);
    const std::size_t triangle = random.index(mesh.triangles().size());
    const double w0 = random.uniform(0, 1);
    switch (family) {
        case Family::vertices:
            return corner(mesh, triangle, random.index(3));
        case Family::edges:
            return on_triangle(mesh, triangle, w0, 1 - w0);
        case Family::faces:
            return on_triangle(mesh, triangle, w0, (1 - w0) * random.uniform(0, 1));
        case Family::beside:
            return along(on_triangle(mesh, triangle, w0, (1 - w0) * random.uniform(0, 1)),
                         side * std::pow(10, random.uniform(-15, -2)), random.direction());
        case Family::around:
            return along(corner(mesh, triangle, 0), side * random.uniform(0, 1), random.direction());
        case Family::far:
            return along(corner(mesh, triangle, 0), side * std::pow(10, random.uniform(1, 11)), random.direction());
        case Family::denormal:
            return {5e-324 * random.index(9), -1e-310 * random.uniform(0, 1), 1e-320 * random.index(3)};
        case Family::centre:
            break;
    }
    Vec3 p{};
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = (mesh.box().lower[axis] + mesh.box().upper[axis]) / 2;
    return along(p, random.index(2) * side * std::pow(10, random.uniform(-16, -3)), random.direction());
}

void check_same_bytes(const Mesh& mesh, const std::vector<Vec3>& points, double half_width,
                      const DistanceTransform& by_vector, const DistanceTransform& by_group) {
    const Field expected = query(by_vector, points, half_width), found = query(by_group, points, half_width);
    for (const OutputInfo& info : output_table()) {
        const auto& a = expected.bytes(info.output);
        const auto& b = found.bytes(info.output);
        const bool are_same = a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0;
        BOOST_TEST(are_same, mesh.name() << ", " << points.size() << " points, half width " << half_width << ": "
                                         << info.name << " differs");
    }
}

std::vector<Mesh> hostile_meshes(Random& random) {
    return {cube(1),
            without_triangle(cube(1), 3),
            overlapping_cubes(),
            sliver(),
            fins(),
            cone(500),
            random_slivers(random, 60),
            random_soup(random, 30, 200),
            make_shape("sphere4"),
            tilted(make_shape("noisy")),
            shifted(make_shape("torus"), {3e6, -5e6, 7e6}),
            scaled(make_shape("knot"), 1e-30),
            deep_mesh(4096)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(both_searches_give_the_same_bytes) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Mesh& mesh : hostile_meshes(random)) {
        const DistanceTransform by_vector(test_device(), mesh, {.body = KernelBody::by_vector});
        const DistanceTransform by_group(test_device(), mesh, {.body = KernelBody::by_group});
        BOOST_TEST_CONTEXT("seed " << seed) {
            for (const Family family : families) {
                std::vector<Vec3> points(500);
                for (Vec3& p : points) p = point_of(family, mesh, random);
                for (const double half_width : {no_limit, 0.01 * mesh.box().longest_side(), 0.0})
                    check_same_bytes(mesh, points, half_width, by_vector, by_group);
            }
            for (const std::size_t count : {1U, 96U, 97U}) {
                std::vector<Vec3> points(count);
                for (Vec3& p : points) p = point_of(families[random.index(families.size())], mesh, random);
                check_same_bytes(mesh, points, no_limit, by_vector, by_group);
            }
        }
    }
}

// Among so many that the processor scans them in groups.
BOOST_AUTO_TEST_CASE(many_points_have_the_same_bytes) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Mesh& mesh : {tilted(make_shape("noisy")), random_soup(random, 30, 200)}) {
        std::vector<Vec3> points(16384);
        for (Vec3& p : points) p = point_of(families[random.index(families.size() - 3)], mesh, random);
        const DistanceTransform by_vector(test_device(), mesh, {.body = KernelBody::by_vector});
        const DistanceTransform by_group(test_device(), mesh, {.body = KernelBody::by_group});
        BOOST_TEST_CONTEXT("seed " << seed)
        check_same_bytes(mesh, points, no_limit, by_vector, by_group);
    }
}

// The tree of the first positions serves the next ones; some are so different that it is made anew.
BOOST_AUTO_TEST_CASE(a_mesh_that_moves_has_the_bytes_of_a_new_one) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    const Mesh mesh = tilted(make_shape("noisy"));
    DistanceTransform moving(test_device(), mesh, {.body = KernelBody::by_group});
    for (int step = 0; step < 4; ++step) {
        const Mesh there = step == 2 ? moved(mesh, [&](const Vec3&) { return random.point(-1, 1); })
                                     : shifted(scaled(mesh, 1 + step), {0.1 * step, 0, 3});
        moving.set_positions(there.vertices());
        const DistanceTransform by_vector(test_device(), there, {.body = KernelBody::by_vector});
        std::vector<Vec3> points(300);
        for (Vec3& p : points) p = point_of(families[random.index(families.size())], there, random);
        BOOST_TEST_CONTEXT("seed " << seed << ", step " << step) {
            const Field found = query(moving, points), expected = query(by_vector, points);
            std::size_t different = 0;
            for (std::size_t i = 0; i < points.size(); ++i)
                different += std::memcmp(&found.distance()[i], &expected.distance()[i], sizeof(float)) != 0;
            BOOST_TEST(different == 0U);
        }
    }
}

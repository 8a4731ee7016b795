// Distances to the union of the bodies of a scene, against cells between boxes and against the cut union.
#include "random_scenes.hpp"

#include "support/box_unions.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

Scene union_scene() {
    return Scene(test_device(), {.surface = Surface::outer});
}

Pose at(const Vec3& translation) {
    return {.translation = translation};
}

Pose turned(Random& random, const Vec3& translation) {
    return {random_rotation(random), translation};
}

double distance_between(const Vec3& a, const Vec3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Signed distances to the cut union.
std::vector<double> of_cut_union(const Scene& scene, std::span<const Vec3> points) {
    return distances(DistanceTransform(test_device(), scene.outer().surface.mesh), points);
}

/// Points around the bodies, half of them deep in their box.
std::vector<Vec3> points_among(const Scene& scene, Random& random, int count) {
    const Box box = scene.box();
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        Vec3& p = points.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = box.upper[axis] - box.lower[axis];
            p[axis] = random.uniform(box.lower[axis] - 0.05 * side, box.upper[axis] + 0.05 * side);
        }
    }
    return points;
}

/// Inside boxes, and not on their boundary.
void check_boxes(const std::vector<Box>& boxes, std::span<const Vec3> points) {
    Scene scene = union_scene();
    for (const Box& one : boxes) scene.add(box(one.lower, one.upper));
    const PointValues found = query(scene, points);
    std::vector<std::uint8_t> inside(points.size());
    scene.contains(points, inside);
    const Cells cells(boxes);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double distance = cells.distance(points[i]);
        const bool is_in_box = std::ranges::any_of(boxes, [&](const Box& one) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (points[i][axis] < one.lower[axis] || points[i][axis] > one.upper[axis]) return false;
            return true;
        });
        const double expected = is_in_box && distance > 0 ? -distance : distance;
        const bool is_right = std::abs(found.distance[i] - expected) < 2e-15 &&
                              (expected == 0 || std::signbit(found.distance[i]) == std::signbit(expected)) &&
                              (inside[i] != 0) == (expected < 0) && found.is_own[i] == 1 &&
                              std::abs(distance_between(points[i], found.closest[i]) - distance) < 2e-15 &&
                              cells.distance(found.closest[i]) < 2e-15;
        wrong += is_right ? 0U : 1U;
        if (!is_right)
            BOOST_TEST_MESSAGE("at " << points[i][0] << " " << points[i][1] << " " << points[i][2] << ": "
                                     << found.distance[i] << " is " << expected << " inside " << int(inside[i]));
    }
    BOOST_TEST(wrong == 0U);
}

/// The points of a lattice of eighths, on which all sides lie, and others.
std::vector<Vec3> points_of_boxes(Random& random) {
    std::vector<Vec3> points;
    for (int i = 0; i < 400; ++i) {
        Vec3& p = points.emplace_back(random.point(-0.5, 3.5));
        if (i % 2 == 0)
            for (double& x : p) x = std::round(8 * x) / 8;
    }
    return points;
}

}  // namespace

BOOST_AUTO_TEST_CASE(two_boxes_in_all_positions) {
    Random random(1);
    const std::vector<Vec3> points = points_of_boxes(random);
    const Box first{{1, 1, 1}, {2, 2, 2}};
    const std::vector<Box> others{
        {{1.25, 1.25, 1.25}, {1.75, 1.75, 1.75}},  // nested
        {{2, 1, 1}, {3, 2, 2}},                    // sharing a face
        {{2, 1.25, 1.25}, {3, 1.75, 1.75}},        // a face within a face
        {{2, 1.5, 1.5}, {3, 2.5, 2.5}},            // faces that overlap
        {{1.5, 1, 1}, {2.5, 2, 2}},                // coplanar sides that overlap
        {{1, 1, 1}, {2, 2, 2}},                    // the same twice
        {{1, 1, 1}, {1.5, 1.5, 1.5}},              // in a corner
        {{2, 2, 2}, {3, 3, 3}},                    // touching in a vertex,
        {{2, 2, 1}, {3, 3, 2}},                    // in an edge,
        {{2, 2, 1.5}, {3, 3, 2.5}},                // in a part of an edge
        {{0.5, 1.25, 1.25}, {2.5, 1.75, 1.75}},    // through it
        {{1.5, 1.5, 1.5}, {2.5, 2.5, 2.5}},        // crossing
        {{2.5, 1, 1}, {3, 2, 2}},                  // apart
    };
    for (const Box& other : others) check_boxes({first, other}, points);
    check_boxes({first, others[1], {{1, 2, 1}, {3, 3, 2}}, {{1.5, 1.5, 2}, {2.5, 2.5, 3}}}, points);
}

BOOST_AUTO_TEST_CASE(unions_of_random_boxes) {
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        Random random(seed);
        std::vector<Box> boxes;
        const double parts = std::array{4.0, 6.0, 7.0}[seed % 3];
        for (std::uint32_t i = 2 + random.index(7); i > 0; --i) {
            Box& one = boxes.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double begin = random.index(10), size = 1 + random.index(6);
                one.lower[axis] = begin / parts;
                one.upper[axis] = (begin + size) / parts;
            }
        }
        check_boxes(boxes, points_of_boxes(random));
    }
}

BOOST_AUTO_TEST_CASE(random_scenes_have_the_distances_of_their_cut_union) {
    std::size_t wrong = 0, inside = 0, deeper = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        Random random(seed);
        std::vector<Mesh> meshes{cube(0.8), make_shape("sphere2"), tilted(plate(0.1))};
        for (int i = 0; i < 2; ++i) meshes.push_back(random_closed(random, 1 + random.index(3)));
        Scene scene = union_scene(), given(test_device());
        const Vec3 all_at = seed % 4 == 0 ? random.point(-1e6, 1e6) : Vec3{};
        for (std::uint32_t i = 2 + random.index(6); i > 0; --i) {
            Vec3 where = random.point(-1, 1);
            for (std::size_t axis = 0; axis < 3; ++axis) where[axis] += all_at[axis];
            const Pose pose = seed % 3 == 0 ? at(where) : turned(random, where);
            if (const std::uint32_t number = random.index(meshes.size()); random.index(3) > 0 || scene.size() == 0) {
                scene.add(meshes[number], pose);
                given.add(meshes[number], pose);
            } else {
                const std::uint32_t of = random.index(scene.size());
                scene.add_instance(of, pose);
                given.add_instance(of, pose);
            }
        }
        const std::vector<Vec3> points = points_among(given, random, 300);
        const PointValues found = query(scene, points), least = query(given, points);
        const std::vector<double> expected = of_cut_union(given, points);
        const double tolerance = all_at == Vec3{} ? 1e-13 : 2e-9;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double error = std::abs(found.distance[i] - expected[i]);
            inside += expected[i] < 0 ? 1U : 0U;
            deeper += expected[i] < least.distance[i] - 1e-6 ? 1U : 0U;
            const bool is_right =
                error < tolerance &&
                std::abs(distance_between(points[i], found.closest[i]) - std::abs(expected[i])) < tolerance;
            wrong += is_right ? 0U : 1U;
            if (!is_right)
                BOOST_TEST_MESSAGE("seed " << seed << " point " << i << ": " << found.distance[i] << " is "
                                           << expected[i] << ", error " << error << ", least " << least.distance[i]);
        }
    }
    BOOST_TEST_MESSAGE("inside " << inside << " deeper " << deeper);
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(inside > 10000U);
    BOOST_TEST(deeper > 1000U);
}

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

Vec3 moved(const Pose& pose, const Vec3& p) {
    Vec3 result = pose.translation;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) result[a] += pose.rotation[a][b] * p[b];
    return result;
}

/// The union of boxes, each a body of its own, all in one pose. Walls in which they touch are no surface.
void check_boxes(const std::vector<Box>& boxes, std::span<const Vec3> points, const Pose& pose = {}) {
    Scene scene = union_scene();
    for (const Box& one : boxes) scene.add(box(one.lower, one.upper), pose);
    std::vector<Vec3> asked;
    for (const Vec3& p : points) asked.push_back(pose.rotation == Pose{}.rotation ? p : moved(pose, p));
    const PointValues found = query(scene, asked);
    std::vector<std::uint8_t> inside(points.size());
    scene.contains(asked, inside);
    double largest = 4;
    for (const double x : pose.translation) largest = std::max(largest, std::abs(x));
    const bool is_exact = pose.rotation == Pose{}.rotation;
    const double tolerance = is_exact ? 4e-15 : 4e-15 * largest;
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
        const bool is_right =
            std::abs(found.distance[i] - expected) < tolerance && found.is_own[i] == 1 &&
            (distance < tolerance || std::signbit(found.distance[i]) == std::signbit(expected)) &&
            (!is_exact || (inside[i] != 0) == (expected < 0)) &&
            std::abs(distance_between(asked[i], found.closest[i]) - distance) < tolerance &&
            (!is_exact || cells.distance(found.closest[i]) < tolerance);
        wrong += is_right ? 0U : 1U;
        if (!is_right)
            BOOST_TEST_MESSAGE("at " << points[i][0] << " " << points[i][1] << " " << points[i][2] << ": "
                                     << found.distance[i] << " is " << expected << " inside " << int(inside[i])
                                     << " closest off by " << cells.distance(found.closest[i]));
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
    for (int pose = 0; pose < 6; ++pose) {
        const Pose all = pose == 0 ? Pose{} : turned(random, pose < 4 ? random.point(-1, 1) : random.point(-1e6, 1e6));
        for (const Box& other : others) check_boxes({first, other}, points, all);
        check_boxes({first, others[1], {{1, 2, 1}, {3, 3, 2}}, {{1.5, 1.5, 2}, {2.5, 2.5, 3}}}, points, all);
    }
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
        check_boxes(boxes, points_of_boxes(random), seed % 3 == 1 ? turned(random, random.point(-3, 3)) : Pose{});
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
    BOOST_TEST(inside > 8000U);
    BOOST_TEST(deeper > 1000U);
}

namespace {

/// Capsule-like links, each turned about its joint.
struct Arm {
    explicit Arm(const char* shape, std::size_t links) : link(scaled_link(make_shape(shape))), poses(links) {
        double angle = 0;
        for (std::size_t i = 0; i < links; ++i) {
            angle += 0.2 + 0.1 * static_cast<double>(i % 3);
            const double c = std::cos(angle), s = std::sin(angle);
            Pose& pose = poses[i];
            pose.rotation = {{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}};
            if (i > 0) {
                pose.translation = poses[i - 1].translation;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    pose.translation[axis] += 0.22 * poses[i - 1].rotation[axis][2];
            }
        }
    }
    static Mesh scaled_link(Mesh mesh) {
        return moved_mesh(mesh);
    }
    static Mesh moved_mesh(const Mesh& mesh) {
        return test::moved(mesh, [](const Vec3& p) { return Vec3{0.05 * p[0], 0.05 * p[1], 0.15 * p[2] + 0.13}; });
    }

    Mesh link;
    std::vector<Pose> poses;
};

}  // namespace

BOOST_AUTO_TEST_CASE(an_arm_of_links) {
    const Arm arm("sphere4", 20);
    Scene scene = union_scene();
    scene.add(arm.link);
    for (std::size_t i = 1; i < arm.poses.size(); ++i) scene.add_instance(0);
    scene.set_poses(arm.poses);
    Random random(3);
    std::vector<Vec3> points;
    for (int i = 0; i < 3000; ++i) {
        const Vec3& vertex = arm.link.vertices()[random.index(arm.link.vertices().size())];
        points.push_back(moved(arm.poses[random.index(arm.poses.size())],
                               {vertex[0] * random.uniform(0, 1.1), vertex[1] * random.uniform(0, 1.1), vertex[2]}));
    }
    const PointValues found = query(scene, points);
    const std::vector<double> expected = of_cut_union(scene, points);
    std::size_t wrong = 0, inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        inside += expected[i] < 0 ? 1U : 0U;
        wrong += std::abs(found.distance[i] - expected[i]) < 1e-14 ? 0U : 1U;
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(inside > 1000U);
}

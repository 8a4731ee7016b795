// Distances to the union of the bodies of a scene, against cells between boxes and against the cut union.
#include "random_scenes.hpp"

#include "support/box_unions.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
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
        const bool is_right = std::abs(found.distance[i] - expected) < tolerance && found.is_own[i] == 1 &&
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
            const bool is_right = error < tolerance && std::abs(distance_between(points[i], found.closest[i]) -
                                                                std::abs(expected[i])) < tolerance;
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
    static Mesh scaled_link(Mesh mesh) { return moved_mesh(mesh); }
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

// Bodies with parts of their own that overlap, in overlaps: what all outputs say of one closest point.
BOOST_AUTO_TEST_CASE(outputs_belong_to_the_closest_point) {
    std::size_t wrong = 0, cuts = 0, faces = 0;
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        Random random(seed);
        const std::vector<Mesh> meshes{cube(0.8), make_shape("sphere2"), random_closed(random, 3), overlapping_cubes()};
        Scene scene = union_scene();
        std::vector<Pose> poses;
        for (const Mesh& mesh : meshes) scene.add(mesh, poses.emplace_back(turned(random, random.point(-0.7, 0.7))));
        const std::vector<Vec3> points = points_among(scene, random, 300);
        PointValues found(points.size());
        std::vector<std::uint8_t> site(points.size());
        std::vector<double> weights(2 * points.size());
        SceneTargets targets = found.targets();
        targets.outputs[Output::site] = OutputArray(site);
        targets.outputs[Output::barycentric] = OutputArray(weights);
        scene.query(points, no_limit, targets);
        for (std::size_t i = 0; i < points.size(); ++i) {
            BOOST_REQUIRE(found.body[i] < meshes.size());
            const Mesh& mesh = meshes[found.body[i]];
            BOOST_REQUIRE(found.triangle[i] < mesh.triangles().size());
            const Triangle& triangle = mesh.triangles()[found.triangle[i]];
            const double u = weights[2 * i], v = weights[2 * i + 1];
            Vec3 of_weights{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                of_weights[axis] = (1 - u - v) * mesh.vertices()[triangle[0]][axis] +
                                   u * mesh.vertices()[triangle[1]][axis] + v * mesh.vertices()[triangle[2]][axis];
            of_weights = moved(poses[found.body[i]], of_weights);
            const double distance = std::abs(found.distance[i]), sign = found.distance[i] < 0 ? -1 : 1;
            bool is_right = distance_between(of_weights, found.closest[i]) < 1e-11 && site[i] <= 7 &&
                            std::abs(distance_between(points[i], found.closest[i]) - distance) < 1e-13;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double offset = found.closest[i][axis] - points[i][axis];
                is_right = is_right && std::abs(found.offset[i][axis] - offset) < 1e-13 &&
                           (distance < 1e-6 || std::abs(found.gradient[i][axis] + sign * offset / distance) < 1e-7);
            }
            wrong += is_right ? 0U : 1U;
            cuts += site[i] == 7 ? 1U : 0U;
            faces += site[i] == 6 && found.distance[i] < 0 ? 1U : 0U;
        }
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(cuts > 50U);
    BOOST_TEST(faces > 500U);
}

// [-1, 1]^3 and the same 1.5 to the right: (0.75, 0, 0) is 1 from the sides, and 0.25 deep in both.
BOOST_AUTO_TEST_CASE(moved_bodies_have_another_union) {
    Scene scene = union_scene();
    scene.add(cube(1));
    scene.add_instance(0, at({1.5, 0, 0}));
    const std::vector<Vec3> point{{0.75, 0.0, 0.0}};
    const auto distance = [&](double half_width = no_limit) { return query(scene, point, half_width).distance[0]; };
    const auto is_near = [](double found, double expected) { return std::abs(found - expected) < 1e-14; };
    BOOST_TEST(is_near(distance(), -1));
    BOOST_TEST(query(scene, point, 0.5).distance[0] == -0.5);
    BOOST_TEST(query(scene, point, 0.5).body[0] == no_body);
    BOOST_TEST(int{query(scene, point, 0.5).is_own[0]} == 1);
    BOOST_TEST(scene.memory().host_bytes > 0U);
    // The nearest point is on the edge where the side x = 1 leaves the second one.
    scene.set_poses(std::vector<Pose>{Pose{}, at({1.5, 0.5, 0})});
    BOOST_TEST(is_near(distance(), -std::hypot(0.25, 0.5)));
    scene.set_active(1, false);
    BOOST_TEST(is_near(distance(), -0.25));
    scene.set_active(1, true);
    scene.set_positions(0, scaled(cube(1), 0.5).vertices());
    BOOST_TEST(is_near(distance(), of_cut_union(scene, point)[0]));
    scene.set_positions(0, cube(1).vertices());
    // Configurations, each with lines of its own.
    const std::vector<Pose> poses{Pose{}, at({1.5, 0, 0}), Pose{}, at({1.5, 0.5, 0}), Pose{}, at({5, 0, 0})};
    PointValues found(3);
    scene.query_poses(point, poses, no_limit, found.targets());
    for (std::size_t i = 0; i < 3; ++i) {
        scene.set_poses(std::span(poses).subspan(2 * i, 2));
        BOOST_TEST(found.distance[i] == distance());
    }
    // Floats.
    std::vector<float> rounded(1);
    scene.set_poses(std::span(poses).first(2));
    scene.query(point, no_limit, {{{Output::distance, rounded}}});
    BOOST_TEST(rounded[0] == -1.0F);
}

BOOST_AUTO_TEST_CASE(the_outer_surface_of_a_union_tells_the_faces_as_given) {
    Scene scene = union_scene(), given(test_device());
    for (Scene* one : {&scene, &given}) {
        one->add(overlapping_cubes());
        one->add(make_shape("sphere3"), at({0.5, 0.25, 0.125}));
    }
    const SceneSurface found = scene.outer(), expected = given.outer();
    BOOST_TEST(std::abs(found.surface.volume - expected.surface.volume) < 1e-13);
    BOOST_TEST((found.surface.faces == expected.surface.faces));
    BOOST_TEST((found.bodies == expected.bodies));
}

BOOST_AUTO_TEST_CASE(fields_of_a_union_are_those_of_its_cut_surface) {
    Scene scene = union_scene();
    scene.add(overlapping_cubes());
    scene.add(make_shape("sphere3"), at({0.5, 0.25, 0.125}));
    const Grid grid = grid_at({-2, -2, -2}, 0.17, 30);
    const Band band = Band::symmetric(0.5);
    for (const double shift : {0.0, 0.75}) {
        scene.set_poses(std::vector<Pose>{at({shift, 0, 0}), at({0.5, 0.25, 0.125})});
        const SceneSurface surface = scene.outer();
        const DistanceTransform transform(test_device(), surface.surface.mesh);
        const Field found = scene.compute(grid, band, Output::triangle | Output::body | Output::gradient);
        const Field expected = transform.compute(grid, band, Output::triangle | Output::gradient);
        BOOST_TEST(std::ranges::equal(found.distance(), expected.distance()));
        BOOST_TEST(std::memcmp(found.gradient().data(), expected.gradient().data(), found.gradient().size_bytes()) ==
                   0);
        for (std::size_t i = 0; i < expected.triangle().size(); ++i) {
            const std::uint32_t triangle = expected.triangle()[i];
            const bool is_near = triangle != no_triangle;
            BOOST_TEST(found.body()[i] == (is_near ? surface.bodies[triangle] : no_body));
            BOOST_TEST(found.triangle()[i] == (is_near ? surface.surface.faces[triangle] : no_triangle));
        }
        // The body alone, and the distance alone.
        BOOST_TEST(std::ranges::equal(scene.compute(grid, band, Output::body).body(), found.body()));
        BOOST_TEST(std::ranges::equal(scene.compute(grid, band).distance(), found.distance()));
    }
}

namespace {

/// Around the z axis: a ring of `count` vertices between two others.
Mesh spindle(std::size_t count, double radius, double ring, double below, double above) {
    std::vector<Vec3> vertices{{0, 0, below}, {0, 0, above}};
    std::vector<Triangle> triangles;
    const auto n = static_cast<std::uint32_t>(count);
    for (std::uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), ring});
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % n;
        triangles.push_back({0, b, a});
        triangles.push_back({1, a, b});
    }
    return {vertices, triangles, "spindle"};
}

}  // namespace

// The tip of a body touches the deepest point of another one's pit, where that has many narrow faces.
BOOST_AUTO_TEST_CASE(a_tip_in_a_pit_hides_nothing) {
    Scene scene = union_scene();
    scene.add(spindle(40, 1, 0, -2, -0.5));
    scene.add(spindle(40, 0.3, 1, -0.5, 2));
    std::vector<Vec3> points;
    for (int i = 1; i <= 20; ++i) points.push_back({0.0, 0.0, -0.5 - 0.005 * i});
    const PointValues found = query(scene, points);
    for (std::size_t i = 0; i < points.size(); ++i)
        BOOST_TEST(std::abs(found.distance[i] - (points[i][2] + 0.5)) < 1e-14);
}

BOOST_AUTO_TEST_CASE(what_a_union_does_not_have_is_named) {
    Scene scene = union_scene();
    const Mesh sheet({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, "sheet");
    check_throws(ErrorCode::unsupported, {"sheet", "close_down"}, [&] { scene.add(sheet); });
    check_throws(ErrorCode::unsupported, {"cube", "outer"}, [&] { scene.add(cube(1), {}, SignRule::none); });
    BOOST_TEST(scene.size() == 0U);
    scene.add(cube(1));
    check_throws(ErrorCode::unsupported, {"barycentric", "look points up"}, [&] {
        scene.compute(grid_at({-2, -2, -2}, 0.5, 9), Band::full(), Output::barycentric);
    });
    const std::vector<double> half_widths{1};
    const std::vector<Vec3> point{{0, 0, 0}};
    std::vector<double> distance(1);
    check_throws(ErrorCode::invalid_argument, {"half width"}, [&] {
        scene.query(point, half_widths, {{{Output::distance, distance}}});
    });
}

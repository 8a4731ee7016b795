#include "random_scenes.hpp"

#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <cstring>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

Pose at(const Vec3& translation) {
    return {.translation = translation};
}

/// To the rounding of these bodies.
bool is_near(double found, double expected) {
    return std::abs(found - expected) < 1e-13;
}

constexpr Pose quarter_turn{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, {2, 0, 0}};

}  // namespace

// cube(a) is [-a, a]^3.
BOOST_AUTO_TEST_CASE(a_small_body_in_a_large_one_does_not_count) {
    Scene scene(test_device());
    scene.add(cube(10));
    scene.add(cube(0.5), at({3, 0, 0}));
    const std::vector<Vec3> points{{3, 0, 0}, {3.5, 0, 0}, {3.4, 0, 0}, {3.75, 0, 0}, {9.9, 0, 0}, {11, 0, 0}};
    const PointValues found = query(scene, points);
    const std::vector<double> expected{-7, -6.5, -6.6, -6.25, -0.1, 1};
    for (std::size_t i = 0; i < points.size(); ++i) {
        BOOST_TEST(is_near(found.distance[i], expected[i]));
        BOOST_TEST(found.body[i] == 0U);
        BOOST_TEST(int{found.is_own[i]} == 1);
    }
    // Within 1 of the small body's surface: there is no body near the point, in the depth of the large one.
    const PointValues near = query(scene, points, 1);
    for (std::size_t i = 0; i < 4; ++i) {
        BOOST_TEST(near.distance[i] == -1.0);
        BOOST_TEST(near.body[i] == no_body);
        BOOST_TEST(near.triangle[i] == no_triangle);
        BOOST_TEST(std::isnan(near.closest[i][0]));
    }
}

BOOST_AUTO_TEST_CASE(the_depth_is_that_of_the_deepest_body_and_says_where_it_is_the_unions) {
    Scene scene(test_device());
    scene.add(cube(1));
    scene.add(cube(1), at({1.5, 0, 0}));
    scene.add(cube(1), at({-2, 5, 0}));  // shares no point with the others
    // In both cubes; in one of them, where the nearest face lies in the other one; in the union's corner.
    const std::vector<Vec3> points{{0.7, 0, 0}, {0.9, 0.95, 0}, {0.4, 0, 0}, {-0.9, 0, 0}, {-2, 5, 0.5}};
    const PointValues found = query(scene, points);
    const std::vector<double> expected{-0.3, -0.05, -0.6, -0.1, -0.5};
    const std::vector<std::uint32_t> bodies{0, 0, 0, 0, 2};
    const std::vector<int> own{0, 1, 0, 1, 1};
    for (std::size_t i = 0; i < points.size(); ++i) {
        BOOST_TEST(is_near(found.distance[i], expected[i]));
        if (i != 1) BOOST_TEST(found.body[i] == bodies[i]);
        if (i != 1) BOOST_TEST(int{found.is_own[i]} == own[i]);
    }
}

BOOST_AUTO_TEST_CASE(equal_bodies_have_the_lowest_number) {
    Scene scene(test_device());
    const std::uint32_t first = scene.add(make_shape("sphere2"));
    scene.add_instance(first);
    scene.add(make_shape("sphere2"));
    Random random(7);
    std::vector<Vec3> points;
    for (int i = 0; i < 100; ++i) points.push_back(random.point(-2, 2));
    for (const std::uint32_t body : query(scene, points).body) BOOST_TEST(body == 0U);
    scene.set_active(0, false);
    for (const std::uint32_t body : query(scene, points).body) BOOST_TEST(body == 1U);
    scene.set_active(0, true);
    for (const std::uint32_t body : query(scene, points).body) BOOST_TEST(body == 0U);
}

// Body 1 is three cubes: its box holds points of the first cube deeper than that of body 0.
BOOST_AUTO_TEST_CASE(the_lowest_number_wins_in_whatever_order_bodies_are_searched) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const Mesh one = cube(1);
    for (const double shift : {0.0, 8.0, -8.0}) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (const auto& [a, b, c] : one.triangles()) triangles.push_back({a + first, b + first, c + first});
        for (const auto& [x, y, z] : one.vertices()) vertices.push_back({x + shift, y + shift, z + shift});
    }
    Scene scene(test_device());
    scene.add(one);
    scene.add(Mesh(vertices, triangles, "three cubes"));
    // Inside the first cube, with few bits, so that both bodies have exactly the same values.
    Random random(23);
    std::vector<Vec3> points;
    for (int i = 0; i < 200; ++i) {
        Vec3& p = points.emplace_back(random.point(-0.9, 0.9));
        for (double& x : p) x = std::round(64 * x) / 64;
    }
    for (const std::uint32_t body : query(scene, points).body) BOOST_TEST(body == 0U);
}

BOOST_AUTO_TEST_CASE(each_body_may_have_a_half_width) {
    std::size_t wrong = 0, compared = 0, of_others = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        RandomScene random(seed);
        std::vector<double> half_widths;
        for (std::size_t i = 0; i < random.bodies.size(); ++i)
            half_widths.push_back(std::array{0.0, 0.1, 0.5, 2.0, 40.0}[random.random.index(5)]);
        const double greatest = std::ranges::max(half_widths);
        PointValues found(random.points.size());
        const SceneTargets targets = found.targets();
        random.scene.query(random.points, half_widths, {targets.outputs});
        std::vector<PointOfBody> pairs;
        for (std::uint32_t body = 0; body < random.bodies.size(); ++body) pairs.push_back({0, body});
        std::vector<double> of_pairs(pairs.size());
        random.scene.query_pairs(random.points, pairs, half_widths, {{Output::distance, of_pairs}});
        for (std::size_t i = 0; i < random.points.size(); ++i) {
            double least = no_limit, without_limits = no_limit;
            bool is_at_limit = false;
            for (std::size_t body = 0; body < half_widths.size(); ++body) {
                const double value = random.of_bodies[body][i], width = half_widths[body];
                is_at_limit = is_at_limit || std::abs(std::abs(value) - width) < random.tolerance;
                if (i == 0 && !is_at_limit)
                    wrong += std::abs(of_pairs[body] - std::clamp(value, -width, width)) > random.tolerance ? 1U : 0U;
                if (value <= width) least = std::min(least, value < -width ? -no_limit : value);
                without_limits = std::min(without_limits, value);
            }
            if (is_at_limit) continue;
            ++compared;
            of_others += std::isfinite(least) && least != without_limits ? 1U : 0U;
            wrong += std::abs(found.distance[i] - std::clamp(least, -greatest, greatest)) > random.tolerance ? 1U : 0U;
            wrong += (found.body[i] == no_body) != std::isinf(least) ? 1U : 0U;
        }
    }
    BOOST_TEST(wrong == 0U, "seeds 1 to 60");
    BOOST_TEST(compared > 1000U);
    BOOST_TEST(of_others > 20U);
    Scene scene(test_device());
    scene.add(cube(1));
    const std::vector<Vec3> point{{0, 0, 0}};
    PointValues found(1);
    check_throws(ErrorCode::invalid_argument, {"2 half widths", "1 bodies"}, [&] {
        scene.query(point, std::array{1.0, 1.0}, {found.targets().outputs});
    });
    check_throws(ErrorCode::invalid_argument, {"is_own"},
                 [&] { scene.query(point, std::array{1.0}, found.targets()); });
    check_throws(ErrorCode::invalid_argument, {"-1"},
                 [&] { scene.query(point, std::array{-1.0}, {found.targets().outputs}); });
}

BOOST_AUTO_TEST_CASE(a_body_that_has_not_moved_has_the_bytes_of_its_transform) {
    const Mesh mesh = make_shape("torus");
    Scene scene(test_device());
    scene.add(mesh);
    const DistanceTransform transform(test_device(), mesh);
    Random random(11);
    std::vector<Vec3> points(mesh.vertices().begin(), mesh.vertices().begin() + 30);
    for (int i = 0; i < 300; ++i) points.push_back(random.point(-2, 2));
    points.push_back({std::nan(""), 0, 0});
    points.push_back({1e30, 0, 0});
    points.push_back({1e200, 0, 0});  // whose square is no number
    for (const double half_width : {no_limit, 0.1, 0.0}) {
        const Field expected = query(transform, points, half_width);
        Field found;
        for (const OutputInfo& info : output_table()) found.resize(info.output, points.size());
        const TransformStatistics statistics = scene.query(points, half_width, {found.targets()});
        for (const OutputInfo& info : output_table())
            BOOST_TEST(differences(expected, 0, found, 0, points.size(), info).count == 0U,
                       info.name << " within " << half_width);
        if (half_width == no_limit) BOOST_TEST(statistics.unusable_points == 3U);
    }
}

BOOST_AUTO_TEST_CASE(results_are_in_the_coordinates_of_the_scene) {
    Scene scene(test_device());
    scene.add(cube(1), quarter_turn);
    const PointValues found = query(scene, std::vector<Vec3>{{2.25, -3, 0.125}});
    BOOST_TEST(is_near(found.distance[0], 2));
    const Vec3 closest{2.25, -1, 0.125}, offset{0, 2, 0}, gradient{0, -1, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        BOOST_TEST(is_near(found.closest[0][axis], closest[axis]));
        BOOST_TEST(is_near(found.offset[0][axis], offset[axis]));
        BOOST_TEST(is_near(found.gradient[0][axis], gradient[axis]));
    }
}

BOOST_AUTO_TEST_CASE(rotations_in_floats_are_made_rotations_again) {
    Random random(13);
    const Mesh mesh = make_shape("sphere2");
    Scene scene(test_device());
    scene.add(mesh);
    for (int i = 0; i < 20; ++i) {
        Pose pose{random_rotation(random), random.point(-5, 5)};
        for (Vec3& row : pose.rotation)
            for (double& x : row) x = static_cast<double>(static_cast<float>(x));
        scene.set_poses(std::span(&pose, 1));
        const Pose used = scene.pose(0);
        DistanceTransform transform(test_device(), mesh);
        transform.set_motion(used.rotation, used.translation);  // refuses what is none to 1e-12
        const std::vector<Vec3> points{random.point(-5, 5)};
        BOOST_TEST(std::abs(query(scene, points).distance[0] - distances(transform, points)[0]) < 1e-13);
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b) BOOST_TEST(std::abs(used.rotation[a][b] - pose.rotation[a][b]) < 1e-6);
    }
}

BOOST_AUTO_TEST_CASE(a_matrix_of_four_rows_is_a_pose) {
    Random random(19);
    std::array<double, 16> matrix{};
    const Pose exact{random_rotation(random), {1, 2, 3}};
    for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b)
            matrix[4 * a + b] = static_cast<double>(static_cast<float>(exact.rotation[a][b]));
        matrix[4 * a + 3] = exact.translation[a];
    }
    check_throws(ErrorCode::invalid_argument, {"last row", "0, 0, 0, 0"}, [&] { pose_of(matrix); });
    matrix[15] = 1;
    const Pose pose = pose_of(matrix);
    BOOST_TEST(pose.translation == exact.translation);
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) {
            double product = a == b ? -1 : 0;
            for (std::size_t k = 0; k < 3; ++k) product += pose.rotation[a][k] * pose.rotation[b][k];
            BOOST_TEST(std::abs(product) < 1e-15);
            BOOST_TEST(std::abs(pose.rotation[a][b] - exact.rotation[a][b]) < 1e-6);
        }
    matrix[3] = std::nan("");
    check_throws(ErrorCode::invalid_argument, {"translation is (nan, 2, 3)"}, [&] { pose_of(matrix); });
    matrix[3] = 1;
    for (double& x : std::span(matrix).first(4)) x = -x;
    check_throws(ErrorCode::invalid_argument, {"the matrix is no rotation"}, [&] { pose_of(matrix); });
}

BOOST_AUTO_TEST_CASE(instances_follow_the_positions_of_their_mesh) {
    const Mesh mesh = cube(1);
    Scene scene(test_device());
    const std::uint32_t body = scene.add(mesh);
    const std::uint32_t instance = scene.add_instance(body, at({10, 0, 0}));
    std::vector<Vec3> larger(mesh.vertices().begin(), mesh.vertices().end());
    for (Vec3& p : larger)
        for (double& x : p) x *= 2;
    scene.set_positions(instance, larger);
    const PointValues found = query(scene, std::vector<Vec3>{{0, 3, 0}, {10, 3, 0}, {13, 0, 0}});
    for (const double distance : found.distance) BOOST_TEST(is_near(distance, 1));
    BOOST_TEST(found.body[1] == instance);
    scene.set_poses(std::array{instance}, std::array{at({0, 10, 0})});
    const PointValues moved = query(scene, std::vector<Vec3>{{0, 3, 0}, {10, 3, 0}, {0, 13, 0}});
    BOOST_TEST(is_near(moved.distance[0], 1));
    BOOST_TEST(is_near(moved.distance[1], std::hypot(8, 1)));
    BOOST_TEST(is_near(moved.distance[2], 1));
    BOOST_TEST(moved.body[2] == instance);
}

BOOST_AUTO_TEST_CASE(configurations_have_the_bytes_of_poses_and_queries) {
    Random random(29);
    Scene scene(test_device());
    const std::uint32_t first = scene.add(make_shape("sphere2"));
    scene.add_instance(first);
    scene.add(cube(0.5), {}, SignRule::none);
    for (const std::size_t count : {3U, 500U}) {
        const std::size_t configurations = 90;
        std::vector<Vec3> points;
        for (std::size_t i = 0; i < count; ++i) points.push_back(random.point(-3, 3));
        points[1] = {std::nan(""), 0, 0};
        std::vector<Pose> poses;
        for (std::size_t i = 0; i < 3 * configurations; ++i)
            poses.push_back({random_rotation(random), random.point(-2, 2)});
        PointValues found(configurations * count);
        const TransformStatistics statistics = scene.query_poses(points, poses, 1, found.targets());
        BOOST_TEST(statistics.unusable_points == configurations);
        Scene other(test_device());
        other.add(make_shape("sphere2"));
        other.add_instance(0);
        other.add(cube(0.5), {}, SignRule::none);
        std::size_t wrong = 0;
        for (std::size_t n = 0; n < configurations; ++n) {
            other.set_poses(std::span(poses).subspan(3 * n, 3));
            const PointValues one = query(other, points, 1);
            wrong +=
                std::memcmp(one.distance.data(), &found.distance[n * count], count * sizeof(double)) != 0 ? 1U : 0U;
            wrong += std::memcmp(one.closest.data(), &found.closest[n * count], count * sizeof(Vec3)) != 0 ? 1U : 0U;
            wrong += std::memcmp(one.body.data(), &found.body[n * count], count * sizeof(std::uint32_t)) != 0 ? 1U : 0U;
            wrong += std::memcmp(one.is_own.data(), &found.is_own[n * count], count) != 0 ? 1U : 0U;
        }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST(scene.pose(1).translation == Vec3{});
        std::vector<double> distance(configurations * count);
        check_throws(ErrorCode::invalid_argument, {"269 poses and 3 bodies"},
                     [&] { scene.query_poses(points, std::span(poses).first(269), 1, {distance}); });
        poses[7].rotation[0][0] += 1;
        check_throws(ErrorCode::invalid_argument, {"body 1 in configuration 2"},
                     [&] { scene.query_poses(points, poses, 1, {distance}); });
    }
}

BOOST_AUTO_TEST_CASE(many_threads_ask_while_nothing_moves) {
    Random random(17);
    Scene scene(test_device());
    const std::uint32_t first = scene.add(make_shape("sphere2"));
    for (int i = 0; i < 200; ++i) scene.add_instance(first, {random_rotation(random), random.point(-20, 20)});
    std::vector<Vec3> points;
    for (int i = 0; i < 500; ++i) points.push_back(random.point(-25, 25));
    const PointValues expected = query(scene, points);
    scene.set_active(0, false);
    scene.set_active(0, true);  // so that the threads make the tree
    std::vector<int> different(4);
    {
        std::vector<std::jthread> threads;
        for (std::size_t thread = 0; thread < different.size(); ++thread)
            threads.emplace_back([&, thread] {
                const PointValues found = query(scene, points);
                different[thread] = found.distance != expected.distance || found.body != expected.body ? 1 : 0;
            });
    }
    for (const int is_different : different) BOOST_TEST(is_different == 0);
}

BOOST_AUTO_TEST_CASE(what_is_wrong_is_named_and_changes_nothing) {
    Scene scene(test_device());
    std::vector<double> one(1);
    const std::vector<Vec3> point{{0, 3, 0}};
    check_throws(ErrorCode::invalid_argument, {"has no bodies"}, [&] { scene.query(point, 1, {one}); });
    const std::uint32_t body = scene.add(cube(1));
    scene.add_instance(body, at({8, 0, 0}));
    check_throws(ErrorCode::invalid_mesh, {},
                 [&] { scene.add(Mesh(std::vector<Vec3>{}, std::vector<Triangle>{}, "nothing")); });
    check_throws(ErrorCode::unsupported, {"below"}, [&] { scene.add(cube(1), {}, SignRule::below); });
    check_throws(ErrorCode::invalid_argument, {"there is no body 2"}, [&] { scene.add_instance(2); });
    check_throws(ErrorCode::invalid_argument, {"there is no body 7"}, [&] { scene.set_active(7, false); });
    std::vector<Pose> poses{at({1, 1, 1}), at({2, 2, 2})};
    poses[1].rotation[0][0] = 1.1;
    check_throws(ErrorCode::invalid_argument, {"body 1 is no rotation"}, [&] { scene.set_poses(poses); });
    poses[1].rotation = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    check_throws(ErrorCode::invalid_argument, {"body 1 is no rotation"}, [&] { scene.set_poses(poses); });
    poses[1] = at({0, std::nan(""), 0});
    check_throws(ErrorCode::invalid_argument, {"translation of body 1"}, [&] { scene.set_poses(poses); });
    check_throws(ErrorCode::invalid_argument, {"1 poses and 2 bodies"},
                 [&] { scene.set_poses(std::span(poses).first(1)); });
    poses[1] = at({5, 0, 0});
    check_throws(ErrorCode::invalid_argument, {"body 0 is named twice"}, [&] {
        scene.set_poses(std::array{0U, 0U}, poses);
    });
    check_throws(ErrorCode::invalid_argument, {"there is no body 3"}, [&] {
        scene.set_poses(std::array{0U, 3U}, poses);
    });
    const std::vector<Vec3> three(3), nowhere{{std::nan(""), 0, 0}};
    check_throws(ErrorCode::invalid_argument, {"3"}, [&] { scene.set_positions(0, three); });
    BOOST_TEST(scene.size() == 2U);
    BOOST_TEST(is_near(query(scene, point).distance[0], 2));

    check_throws(ErrorCode::invalid_argument, {"half width"}, [&] { scene.query(point, -1, {one}); });
    std::vector<std::uint8_t> two(2);
    check_throws(ErrorCode::invalid_argument, {"is_own has 2 items for 1 points"}, [&] {
        scene.query(point, 1, {one, two});
    });
    check_throws(ErrorCode::invalid_argument, {}, [&] {
        scene.query(point, 1, {one, std::span(reinterpret_cast<std::uint8_t*>(one.data()), 1)});
    });
    const auto pair = [&](PointOfBody asked) { scene.query_pairs(point, std::span(&asked, 1), 1, one); };
    check_throws(ErrorCode::invalid_argument, {"pair 0 names point 1"}, [&] { pair({1, 0}); });
    check_throws(ErrorCode::invalid_argument, {"pair 0 names body 2"}, [&] { pair({0, 2}); });
    // Results may lie on the pairs.
    std::vector<PointOfBody> pairs(2000, {1, 0});
    const std::vector<Vec3> points{point.front(), {std::nan(""), 0, 0}};
    std::vector<double> distances(pairs.size());
    scene.query_pairs(points, pairs, 1,
                      {{Output::distance, distances},
                       {Output::triangle, std::span(reinterpret_cast<std::uint32_t*>(pairs.data()), 2000)}});
    BOOST_TEST(pairs.front().point == no_triangle);
    scene.set_active(1, false);
    check_throws(ErrorCode::invalid_argument, {"switched off"}, [&] { pair({0, 1}); });
    check_throws(ErrorCode::invalid_argument, {"counted from 0"},
                 [&] { scene.query(nowhere, 1, {one}, {.refuse_unusable_points = true}); });
    scene.set_active(0, false);
    check_throws(ErrorCode::invalid_argument, {"all 2 bodies"}, [&] { scene.query(point, 1, {one}); });
    BOOST_TEST(!scene.has_sign());
}

#include "support/queries.hpp"
#include "support/throws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

BOOST_AUTO_TEST_CASE(a_mesh_without_extent_has_points_around_it) {
    const Mesh mesh(std::vector<Vec3>{{1, 2, 3}}, std::vector<Triangle>{{0, 0, 0}}, "a point");
    const std::vector<Vec3> points{{1, 2, 3}, {1, 2, 5}, {-3, 5, 3}};
    const Field field = query(DistanceTransform(test_device(), mesh), points);
    BOOST_TEST(field.distance()[0] == 0);
    BOOST_TEST(field.distance()[1] == 2);
    BOOST_TEST(field.distance()[2] == 5);
    BOOST_TEST(field.closest()[6] == 1, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(small_meshes_have_distances_below_the_normal_floats) {
    for (const double side : {4e-36, 1e-32}) {
        const Mesh mesh = box({0, 0, 0}, {side, side, side});
        std::vector<Vec3> points;
        for (const double voxels : {1e-4, 0.01, 0.3}) points.push_back({side / 2, side / 2, -voxels * side / 256});
        const Field field = query(DistanceTransform(test_device(), mesh), points);
        for (std::size_t i = 0; i < points.size(); ++i)
            BOOST_TEST(std::abs(static_cast<double>(field.distance()[i]) + points[i][2]) <= 1e-5 * side / 256);
    }
}

BOOST_AUTO_TEST_CASE(points_may_be_1e14_voxels_from_the_box) {
    for (const double side : {1.0, 1.5, 1.99}) {
        const DistanceTransform transform(test_device(), box({0, 0, 0}, {side, side, side}));
        const double far = 0.99e14 * side / 256;
        std::vector<Vec3> points{{side + far, 0.5, 0.5}, {0.5, -far, 0.5}};
        const Field field = query(transform, points);
        for (const float distance : field.distance())
            BOOST_TEST(std::abs(static_cast<double>(distance) / far - 1) < 1e-6);
        points[1][1] = -1.02 * far;
        std::vector<float> distance(2);
        check_throws(ErrorCode::invalid_argument, {"point 1", "1e14 voxels"},
                     [&] { transform.query(points, no_limit, distance, {.refuse_unusable_points = true}); });
    }
}

BOOST_AUTO_TEST_CASE(points_whose_distance_may_be_beyond_the_floats_are_refused) {
    const DistanceTransform transform(test_device(), cube(1e30));
    std::vector<Vec3> points{{5e37, 0, 0}};
    BOOST_TEST(std::isfinite(query(transform, points).distance()[0]));
    points[0][0] = 1e40;
    std::vector<float> distance(1);
    check_throws(ErrorCode::invalid_argument, {"point 0", "1e+40", "beyond the floats", "leave it out"},
                 [&] { transform.query(points, no_limit, distance, {.refuse_unusable_points = true}); });
    BOOST_TEST(std::isnan(query(transform, points).distance()[0]));
}

BOOST_AUTO_TEST_CASE(points_that_are_not_finite_or_too_far_have_no_distance_and_change_no_other_point) {
    const Mesh mesh = make_shape("knot");
    const DistanceTransform transform(test_device(), mesh);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const std::size_t count : {std::size_t{1}, std::size_t{5}, std::size_t{96}, std::size_t{5000}})
        for (const double half_width : {0.0, 0.05, no_limit})
            for (const std::size_t every : {std::size_t{1}, std::size_t{3}}) {
                BOOST_TEST_CONTEXT(count << " points, half width " << half_width << ", every " << every) {
                    std::vector<Vec3> points = points_around(mesh, count, 5), marked = points;
                    points.resize(count);
                    marked.resize(count);
                    const std::array marks{Vec3{nan, nan, nan}, Vec3{0, no_limit, 0}, Vec3{1e30, 0, 0}};
                    std::size_t not_finite = 0, far = 0;
                    for (std::size_t i = 0; i < count; i += every) {
                        marked[i] = marks[i % 4 % 3];
                        ++(std::isfinite(marked[i][0] + marked[i][1]) ? far : not_finite);
                    }
                    const Field expected = query(transform, points, half_width);
                    std::vector<std::string> warnings;
                    Field found = expected;
                    const TransformStatistics statistics =
                        transform.query(marked, half_width, found.targets(),
                                        {.log = [&](const std::string& warning) { warnings.push_back(warning); }});
                    BOOST_TEST(statistics.unusable_points == not_finite + far);
                    BOOST_TEST_REQUIRE(warnings.size() == 1U);
                    BOOST_TEST(warnings[0].starts_with(std::to_string(not_finite) + " of " + std::to_string(count)));
                    for (std::size_t i = 0; i < count; ++i) {
                        const bool is_marked = i % every == 0, is_far = is_marked && marked[i][0] == 1e30;
                        if (is_far && half_width < no_limit)
                            BOOST_REQUIRE(found.distance()[i] == static_cast<float>(half_width));
                        else if (is_marked)
                            BOOST_REQUIRE(std::isnan(found.distance()[i]));
                        for (const OutputInfo& info : output_table()) {
                            if (!is_marked) {
                                BOOST_REQUIRE(differences(found, i, expected, i, 1, info).count == 0U);
                            } else if (info.output != Output::distance) {
                                const auto bytes =
                                    found.bytes(info.output).subspan(i * info.sample_bytes(), info.sample_bytes());
                                BOOST_REQUIRE(std::ranges::count(bytes, std::byte{0xFF}) ==
                                              static_cast<std::ptrdiff_t>(bytes.size()));
                            }
                        }
                    }
                }
            }
}

BOOST_AUTO_TEST_CASE(points_that_are_not_finite_or_too_far_need_no_region_of_a_part) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const DistanceTransform whole(test_device(), cube(1));
    const DistanceTransform part = whole.restrict_to(Region{{{0, -1, -1}, {2, 1, 1}}, 0.5, 0});
    for (const std::vector<Vec3>& points : {std::vector<Vec3>{{nan, 0, 0}, {0.75, 0, 0}, {1e30, 0, 0}, {0.5, 0.9, 0}},
                                            {{nan, 0, 0}, {1e30, 0, 0}},
                                            {{1e30, 0, 0}}})
        for (const std::size_t copies : {1U, 100U}) {
            std::vector<Vec3> all;
            for (std::size_t i = 0; i < copies; ++i) all.insert(all.end(), points.begin(), points.end());
            const Field expected = query(whole, all, 0.5), found = query(part, all, 0.5);
            for (const OutputInfo& info : output_table())
                BOOST_TEST(differences(found, 0, expected, 0, all.size(), info).count == 0U);
        }
    const std::vector<Vec3> outside{{nan, 0, 0}, {-1, 0, 0}};
    check_throws(ErrorCode::invalid_argument, {"point 1"}, [&] { query(part, outside, 0.5); });
}

BOOST_AUTO_TEST_CASE(errors_name_the_point_and_the_argument) {
    const Mesh mesh = cube(1);
    const DistanceTransform transform(test_device(), mesh);
    std::vector<Vec3> points(5, {0.5, 0, 0});
    std::vector<float> distance(5);
    points[3][1] = std::numeric_limits<double>::quiet_NaN();
    check_throws(ErrorCode::invalid_argument, {"point 3", "nan", "not finite"},
                 [&] { transform.query(points, 1, distance, {.refuse_unusable_points = true}); });
    points[3][1] = 1e300;
    check_throws(ErrorCode::invalid_argument, {"point 3", "1e+300", "1e14 voxels"},
                 [&] { transform.query(points, 1, distance, {.refuse_unusable_points = true}); });
    points[3][1] = 0;
    for (const double half_width : {-1.0, std::numeric_limits<double>::quiet_NaN()})
        check_throws(ErrorCode::invalid_argument, {"half width"},
                     [&] { transform.query(points, half_width, distance); });
    check_throws(ErrorCode::invalid_argument, {"5 points", "distance", "4 values"},
                 [&] { transform.query(points, 1, std::span(distance).first(4)); });
    check_throws(ErrorCode::invalid_argument, {"distance has no target"},
                 [&] { transform.query(points, 1, OutputTargets()); });
    OutputArray in_layers = distance;
    in_layers.strides = {4, 0, 20};
    check_throws(ErrorCode::invalid_argument, {"distance", "(4, 0, 20)", "set strides[0] alone"},
                 [&] { transform.query(points, 1, in_layers); });
    check_throws(ErrorCode::cancelled, {},
                 [&] { transform.query(points, 1, distance, {.should_stop = [] { return true; }}); });
    transform.query(points, 1, distance);
    BOOST_TEST(distance[0] == -0.5F);
}

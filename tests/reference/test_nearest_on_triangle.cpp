#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include "support/exact_distance.hpp"
#include "support/random_meshes.hpp"

using namespace clsdf;
using namespace clsdf::test;
using reference::Nearest;
using reference::nearest_on_triangle;
using reference::Site;

namespace {

double length(const Vec3& a, const Vec3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double farthest(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::max({length(query, a), length(query, b), length(query, c)});
}

/// The promise: a few units of rounding of the farthest vertex's distance, in distance and closest point alike.
void expect_exact(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Nearest nearest = nearest_on_triangle(query, a, b, c);
    const double unit = std::numeric_limits<double>::epsilon() * farthest(query, a, b, c);
    const long double exact = exact_distance(query, a, b, c);
    BOOST_TEST_CONTEXT("query " << std::hexfloat << query[0] << ' ' << query[1] << ' ' << query[2] << " a " << a[0]
                                << ' ' << a[1] << ' ' << a[2] << " b " << b[0] << ' ' << b[1] << ' ' << b[2] << " c "
                                << c[0] << ' ' << c[1] << ' ' << c[2] << std::defaultfloat << " exact " << exact
                                << " found " << nearest.distance << " site " << static_cast<int>(nearest.site)) {
        BOOST_TEST(std::fabs(static_cast<double>(nearest.distance - exact)) <= 4 * unit);
        // The closest point is rounded to the coordinates' own precision.
        const double coordinate = std::max({std::fabs(query[0]), std::fabs(query[1]), std::fabs(query[2])});
        BOOST_TEST(std::fabs(length(nearest.point, query) - static_cast<double>(exact)) <=
                   8 * unit + 4 * std::numeric_limits<double>::epsilon() * coordinate);
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_site_of_a_plain_triangle_is_found_with_its_closest_point) {
    const Vec3 a{0, 0, 0};
    const Vec3 b{4, 0, 0};
    const Vec3 c{0, 4, 0};
    const struct {
        Vec3 query;
        Site site;
        Vec3 point;
    } cases[] = {{{1, 1, 3}, Site::face, {1, 1, 0}},     {{1, 1, 0}, Site::face, {1, 1, 0}},
                 {{2, -1, 1}, Site::edge0, {2, 0, 0}},   {{3, 3, 2}, Site::edge1, {2, 2, 0}},
                 {{-2, 1, 0}, Site::edge2, {0, 1, 0}},   {{-1, -1, 1}, Site::vertex0, {0, 0, 0}},
                 {{7, -1, 1}, Site::vertex1, {4, 0, 0}}, {{-1, 9, 1}, Site::vertex2, {0, 4, 0}}};
    for (const auto& expected : cases) {
        const Nearest nearest = nearest_on_triangle(expected.query, a, b, c);
        BOOST_TEST_CONTEXT("query " << expected.query[0] << ' ' << expected.query[1] << ' ' << expected.query[2]) {
            BOOST_TEST(static_cast<int>(nearest.site) == static_cast<int>(expected.site));
            BOOST_TEST(length(nearest.point, expected.point) < 1e-15);
            BOOST_TEST(nearest.distance == length(expected.query, expected.point), boost::test_tools::tolerance(1e-15));
        }
    }
}

BOOST_AUTO_TEST_CASE(on_a_border_the_vertex_goes_before_the_edge_before_the_face) {
    const Vec3 a{0.1, 0.2, 0.3};
    const Vec3 b{1.7, 0.4, -0.5};
    const Vec3 c{0.3, 1.9, 0.7};
    BOOST_TEST(static_cast<int>(nearest_on_triangle(a, a, b, c).site) == static_cast<int>(Site::vertex0));
    BOOST_TEST(static_cast<int>(nearest_on_triangle(c, a, b, c).site) == static_cast<int>(Site::vertex2));
    const Vec3 middle{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
    BOOST_TEST(static_cast<int>(nearest_on_triangle(middle, a, b, c).site) == static_cast<int>(Site::edge0));
    // Straight over a vertex and over an edge.
    BOOST_TEST(static_cast<int>(nearest_on_triangle({0, 0, 5}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}).site) ==
               static_cast<int>(Site::vertex0));
    BOOST_TEST(static_cast<int>(nearest_on_triangle({0.5, 0, 5}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}).site) ==
               static_cast<int>(Site::edge0));
}

BOOST_AUTO_TEST_CASE(a_degenerate_triangle_is_its_segments_or_its_point) {
    const Vec3 p{1, 2, 3};
    const Vec3 q{4, 6, 3};
    const Nearest point = nearest_on_triangle({1, 2, 8}, p, p, p);
    BOOST_TEST(point.distance == 5);
    BOOST_TEST(static_cast<int>(point.site) == static_cast<int>(Site::vertex0));
    const Nearest segment = nearest_on_triangle({1, 2, 7}, p, q, p);
    BOOST_TEST(segment.distance == 4);
    const Nearest beside = nearest_on_triangle({2.5, 4, 7}, p, q, q);
    BOOST_TEST(beside.distance == 4, boost::test_tools::tolerance(1e-15));
    BOOST_TEST(static_cast<int>(beside.site) == static_cast<int>(Site::edge0));
    const Nearest collinear = nearest_on_triangle({4, 5, 1}, {0, 0, 0}, {2, 2, 2}, {6, 6, 6});
    BOOST_TEST(collinear.distance == static_cast<double>(exact_distance({4, 5, 1}, {0, 0, 0}, {2, 2, 2}, {6, 6, 6})),
               boost::test_tools::tolerance(1e-15));
}

BOOST_AUTO_TEST_CASE(needles_and_caps_of_every_aspect_are_exact_near_and_far) {
    constexpr std::uint64_t seed = 20;
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        for (int i = 0; i < 3000; ++i) {
            const double height = std::pow(10, random.uniform(-16, 0));
            const double reach = std::pow(10, random.uniform(-14, 2));
            const Vec3 a = random.point(-1, 1);
            const Vec3 b = along(a, 1, random.direction());
            // The position of the third vertex over the long edge: near an end a needle, between them a cap, beside
            // them an obtuse sliver.
            const double t = i % 3 == 0 ? std::pow(10, random.uniform(-16, 0)) : random.uniform(-0.5, 1.5);
            const Vec3 foot{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
            const Vec3 c = along(foot, height, random.direction());
            // Around a random point of the triangle: near every one of its sites, at every distance.
            const double u = random.uniform(0, 1);
            const double v = random.uniform(0, 1 - u);
            const Vec3 on{a[0] + u * (b[0] - a[0]) + v * (c[0] - a[0]), a[1] + u * (b[1] - a[1]) + v * (c[1] - a[1]),
                          a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])};
            expect_exact(along(on, reach, random.direction()), a, b, c);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_point_over_the_face_of_a_sliver_is_exact) {
    // Random directions hardly ever end in the tower of a sliver; build points that do.
    constexpr std::uint64_t seed = 21;
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        for (int i = 0; i < 1000; ++i) {
            const double height = std::pow(10, random.uniform(-14, 0));
            const Vec3 a{random.uniform(-1, 1), 0, 0};
            const Vec3 b{a[0] + 1, 0, 0};
            const Vec3 c{a[0] + random.uniform(0, 1), height, 0};
            const double x = random.uniform(0, 1);
            const double over = std::pow(10, random.uniform(-14, 1));
            Vec3 query{a[0] + x, random.uniform(0, height), over};
            Vec3 corners[3] = {a, b, c};
            const double angle = random.uniform(0, 6.3);
            const double tilt = random.uniform(0, 6.3);
            for (Vec3* p : {&query, &corners[0], &corners[1], &corners[2]}) {
                const Vec3 q = *p;
                const Vec3 r{q[0] * std::cos(angle) - q[1] * std::sin(angle),
                             q[0] * std::sin(angle) + q[1] * std::cos(angle), q[2]};
                *p = {r[0], r[1] * std::cos(tilt) - r[2] * std::sin(tilt),
                      r[1] * std::sin(tilt) + r[2] * std::cos(tilt)};
            }
            expect_exact(query, corners[0], corners[1], corners[2]);
        }
    }
}

BOOST_AUTO_TEST_CASE(far_from_the_origin_only_the_distances_between_the_points_matter) {
    constexpr std::uint64_t seed = 22;
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        for (const double far : {1e6, 1e9}) {
            for (int i = 0; i < 300; ++i) {
                const Vec3 centre{far, -far, far};
                const Vec3 a = along(centre, random.uniform(0, 2), random.direction());
                const Vec3 b = along(centre, random.uniform(0, 2), random.direction());
                const Vec3 c = along(centre, random.uniform(0, 2), random.direction());
                expect_exact(along(centre, random.uniform(0, 3), random.direction()), a, b, c);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(tiny_and_huge_triangles_are_as_exact_as_others) {
    constexpr std::uint64_t seed = 23;
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        for (const double scale : {1e-300, 1e-160, 1e-20, 1e20, 1e160, 1e300}) {
            for (int i = 0; i < 60; ++i) {
                const auto scaled = [&](const Vec3& p) { return Vec3{scale * p[0], scale * p[1], scale * p[2]}; };
                expect_exact(scaled(random.point(-2, 2)), scaled(random.point(-1, 1)), scaled(random.point(-1, 1)),
                             scaled(random.point(-1, 1)));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(triangles_that_share_a_site_return_the_same_bits_for_it) {
    constexpr std::uint64_t seed = 24;
    Random random(seed);
    int shared = 0;
    BOOST_TEST_CONTEXT("seed " << seed) {
        for (int i = 0; i < 2000; ++i) {
            const Vec3 a = random.point(-1, 1);
            const Vec3 b = random.point(-1, 1);
            const Vec3 c = random.point(-1, 1);
            const Vec3 d = random.point(-1, 1);
            const Vec3 query = random.point(-2, 2);
            const Nearest one = nearest_on_triangle(query, a, b, c);
            const Nearest other = nearest_on_triangle(query, b, a, d);
            if (one.site == Site::edge0 && other.site == Site::edge0) {
                ++shared;
                BOOST_TEST(one.distance == other.distance);
                BOOST_TEST((one.point == other.point));
            }
            BOOST_TEST(one.distance == nearest_on_triangle(query, c, b, a).distance);
        }
    }
    BOOST_TEST(shared > 0);
}

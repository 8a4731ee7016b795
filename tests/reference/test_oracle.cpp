#include <clsdf/error.hpp>
#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

using namespace clsdf;
using namespace clsdf::test;
using reference::Nearest;
using reference::nearest_by_brute_force;
using reference::Oracle;

namespace {

void expect_same(const Nearest& found, const Nearest& expected) {
    BOOST_TEST(found.distance == expected.distance);
    BOOST_TEST(found.triangle == expected.triangle);
    BOOST_TEST(static_cast<int>(found.site) == static_cast<int>(expected.site));
    BOOST_TEST((found.point == expected.point));
}

void expect_brute_force(const Mesh& mesh, Random& random, int queries, double reach) {
    const Oracle oracle(mesh);
    for (int i = 0; i < queries; ++i) {
        // Around the mesh, and near its vertices: many triangles tie there.
        const Vec3& vertex = mesh.vertices()[random.index(mesh.vertices().size())];
        const Vec3 query = i % 2 == 0 ? along(vertex, std::pow(10, random.uniform(-16, 0)) * reach, random.direction())
                                      : random.point(-2 * reach, 2 * reach);
        BOOST_TEST_CONTEXT("query " << i << ": " << query[0] << ' ' << query[1] << ' ' << query[2]) {
            expect_same(oracle.nearest(query), nearest_by_brute_force(mesh, query));
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_distances_at_the_counterexamples_are_the_true_ones) {
    for (const Counterexample& example : all_counterexamples()) {
        const Oracle oracle(example.mesh);
        for (const KnownSample& sample : example.samples) {
            BOOST_TEST_CONTEXT(example.name()) {
                BOOST_TEST(std::fabs(oracle.nearest(sample.position).distance - sample.distance) <= sample.tolerance);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(the_counterexamples_are_closed_and_enclose_a_volume_on_the_right_side) {
    for (const Counterexample& example : all_counterexamples()) {
        BOOST_TEST_CONTEXT(example.name()) {
            double volume = 0;
            std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
            for (const Triangle& t : example.mesh.triangles()) {
                const Vec3& a = example.mesh.vertices()[t[0]];
                const Vec3& b = example.mesh.vertices()[t[1]];
                const Vec3& c = example.mesh.vertices()[t[2]];
                volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]);
                for (std::size_t k = 0; k < 3; ++k) {
                    edges.emplace_back(t[k], t[(k + 1) % 3]);
                }
            }
            BOOST_TEST(volume > 0);
            for (const auto& [from, to] : edges) {
                BOOST_TEST(std::ranges::count(edges, std::pair{from, to}) ==
                           std::ranges::count(edges, std::pair{to, from}));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(the_tree_says_what_looking_at_every_triangle_says) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            expect_brute_force(random_soup(random, 12, 60), random, 200, 1);
            expect_brute_force(random_soup(random, 300, 100), random, 200, 1);
            expect_brute_force(random_slivers(random, 200), random, 200, 1);
            expect_brute_force(random_closed(random, 5), random, 200, 1);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_far_from_the_origin_or_of_any_scale_is_searched_completely) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        for (const double scale : {1e-200, 1e-162, 1e-20, 1.0, 1e20, 1e160}) {
            for (const double offset : {0.0, 1e9}) {
                BOOST_TEST_CONTEXT("seed " << seed << " scale " << scale << " offset " << offset) {
                    Random random(seed);
                    const Mesh unit = random_closed(random, 3);
                    std::vector<Vec3> vertices = unit.vertices();
                    for (Vec3& vertex : vertices) {
                        for (double& coordinate : vertex) {
                            coordinate = scale * (coordinate + offset);
                        }
                    }
                    const Mesh mesh(vertices, unit.triangles());
                    const Oracle oracle(mesh);
                    for (int i = 0; i < 60; ++i) {
                        const Vec3 p = random.point(offset - 2, offset + 2);
                        const Vec3 query{scale * p[0], scale * p[1], scale * p[2]};
                        expect_same(oracle.nearest(query), nearest_by_brute_force(mesh, query));
                    }
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(among_equally_near_triangles_the_lowest_index_is_named) {
    // The centre of a cube is equally far from all of its faces; duplicates of a face follow it, turned.
    std::vector<Vec3> vertices;
    for (int i = 0; i < 8; ++i) {
        vertices.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    }
    const std::vector<Triangle> triangles{{5, 7, 6}, {4, 5, 6}, {0, 2, 1}, {1, 2, 3}, {7, 6, 5}, {6, 5, 4}};
    const Mesh mesh(vertices, triangles);
    const Oracle oracle(mesh);
    BOOST_TEST(oracle.nearest({0, 0, 0}).triangle == 0U);
    BOOST_TEST(oracle.nearest({0.25, 0.5, 0.75}).triangle == 0U);
    BOOST_TEST(oracle.nearest({-0.25, -0.5, 0.75}).triangle == 1U);
    BOOST_TEST(oracle.nearest({0, 0, -3}).triangle == 2U);
}

BOOST_AUTO_TEST_CASE(a_bound_hides_what_is_farther_and_nothing_else) {
    Random random(7);
    const Mesh mesh = random_soup(random, 60, 40);
    const Oracle oracle(mesh);
    for (int i = 0; i < 200; ++i) {
        const Vec3 query = random.point(-2, 2);
        const Nearest nearest = oracle.nearest(query);
        const auto at_bound = oracle.nearest_within(query, nearest.distance);
        BOOST_REQUIRE(at_bound.has_value());
        expect_same(*at_bound, nearest);
        BOOST_TEST(!oracle.nearest_within(query, std::nextafter(nearest.distance, 0.0)).has_value());
    }
}

BOOST_AUTO_TEST_CASE(a_single_triangle_of_any_kind_can_be_asked) {
    const Mesh point({{1, 1, 1}}, {{0, 0, 0}});
    BOOST_TEST(Oracle(point).nearest({1, 1, 3}).distance == 2);
    const Mesh segment({{0, 0, 0}, {2, 0, 0}}, {{0, 1, 0}});
    BOOST_TEST(Oracle(segment).nearest({1, 3, 0}).distance == 3);
}

BOOST_AUTO_TEST_CASE(a_point_that_is_not_finite_is_an_error) {
    const Oracle oracle(b1().mesh);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    BOOST_CHECK_THROW(oracle.nearest({0, nan, 0}), Error);
    BOOST_CHECK_THROW(oracle.winding_number({uncovered, 0, 0}), Error);
}

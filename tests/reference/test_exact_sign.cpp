#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include "support/exact_distance.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <numbers>

using namespace clsdf;
using namespace clsdf::test;
using reference::Oracle;

namespace {

/// The winding number as a sum of solid angles (van Oosterom and Strackee), not yet rounded.
double solid_angle_winding(const Mesh& mesh, const Vec3& query) {
    double sum = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        Vec3 r[3];
        double l[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& vertex = mesh.vertices()[triangle[k]];
            r[k] = {vertex[0] - query[0], vertex[1] - query[1], vertex[2] - query[2]};
            l[k] = std::hypot(r[k][0], r[k][1], r[k][2]);
        }
        const auto scalar = [&](std::size_t i, std::size_t k) {
            return r[i][0] * r[k][0] + r[i][1] * r[k][1] + r[i][2] * r[k][2];
        };
        const double volume = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) +
                              r[0][1] * (r[1][2] * r[2][0] - r[1][0] * r[2][2]) +
                              r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
        sum += 2 *
               std::atan2(volume, l[0] * l[1] * l[2] + scalar(0, 1) * l[2] + scalar(1, 2) * l[0] + scalar(2, 0) * l[1]);
    }
    return sum / (4 * std::numbers::pi);
}

bool is_on(const Mesh& mesh, const Vec3& point) {
    return std::ranges::any_of(mesh.triangles(), [&](const Triangle& t) {
        return squared_distance_to_triangle(rational(point), rational(mesh.vertices()[t[0]]),
                                            rational(mesh.vertices()[t[1]]), rational(mesh.vertices()[t[2]])) == 0;
    });
}

void expect_solid_angles(const Mesh& mesh, const Vec3& query) {
    const auto winding = Oracle(mesh).winding_number(query);
    BOOST_REQUIRE(winding.has_value());
    BOOST_TEST(*winding == std::lround(solid_angle_winding(mesh, query)));
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_winding_number_is_the_sum_of_solid_angles) {
    int inside = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = random_closed(random, 1 + random.index(5));
            const Oracle oracle(mesh);
            for (int i = 0; i < 200; ++i) {
                const Vec3 query = random.point(-1.5, 1.5);
                const auto winding = oracle.winding_number(query);
                BOOST_REQUIRE(winding.has_value());
                BOOST_TEST(*winding == std::lround(solid_angle_winding(mesh, query)));
                BOOST_TEST((*winding - *oracle.crossings(query)) % 2 == 0);
                inside += *winding != 0 ? 1 : 0;
            }
        }
    }
    BOOST_TEST(inside > 50);
}

BOOST_AUTO_TEST_CASE(rays_through_vertices_and_edges_count_once) {
    const Mesh mesh = cube(1);
    const Oracle oracle(mesh);
    for (double x = -2; x <= 2; x += 0.5) {
        for (double y = -2; y <= 2; y += 0.5) {
            for (double z = -2; z <= 2; z += 0.5) {
                BOOST_TEST_CONTEXT(x << ' ' << y << ' ' << z) {
                    const double farthest = std::max({std::fabs(x), std::fabs(y), std::fabs(z)});
                    const auto winding = oracle.winding_number({x, y, z});
                    BOOST_TEST(winding.has_value() == (farthest != 1));
                    if (winding) {
                        BOOST_TEST(*winding == (farthest < 1 ? 1 : 0));
                        BOOST_TEST(*oracle.crossings({x, y, z}) % 2 == (farthest < 1 ? 1 : 0));
                    }
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(on_a_lattice_full_of_ties_the_surface_is_exactly_the_surface_and_the_sign_is_right) {
    int ties = 0;
    int inside = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = random_lattice_tetrahedron(random, 0.25);
            const Oracle oracle(mesh);
            for (int i = 0; i < 300; ++i) {
                Vec3 query = random.point(-4.4, 4.4);
                for (double& coordinate : query) {
                    coordinate = 0.25 * std::round(coordinate);
                }
                const auto winding = oracle.winding_number(query);
                BOOST_TEST(winding.has_value() != is_on(mesh, query));
                if (winding) {
                    BOOST_TEST(*winding == std::lround(solid_angle_winding(mesh, query)));
                    inside += *winding != 0 ? 1 : 0;
                } else {
                    ++ties;
                }
            }
        }
    }
    BOOST_TEST(ties > 50);
    BOOST_TEST(inside > 50);
}

BOOST_AUTO_TEST_CASE(a_row_says_what_its_points_say) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const bool lattice = seed % 2 == 0;
            const Mesh mesh = lattice ? random_lattice_tetrahedron(random, 0.25) : random_closed(random, 4);
            const Oracle oracle(mesh);
            std::vector<double> x;
            for (double at = -1.5; at <= 1.5; at += 0.125) {
                x.push_back(at);
            }
            for (int row = 0; row < 20; ++row) {
                const double y = lattice ? 0.25 * random.index(9) - 1 : random.uniform(-1, 1);
                const double z = lattice ? 0.25 * random.index(9) - 1 : random.uniform(-1, 1);
                const auto counts = oracle.count_along_row(x, y, z);
                for (std::size_t i = 0; i < x.size(); ++i) {
                    const auto winding = oracle.winding_number({x[i], y, z});
                    BOOST_TEST(counts[i].has_value() == winding.has_value());
                    if (winding) {
                        BOOST_TEST(counts[i]->winding == *winding);
                        BOOST_TEST(counts[i]->crossings == *oracle.crossings({x[i], y, z}));
                    }
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(one_unit_of_rounding_from_the_surface_decides) {
    const Mesh mesh = cube(1);
    const Oracle oracle(mesh);
    BOOST_TEST(!oracle.winding_number({1, 0.25, 0.5}).has_value());
    BOOST_TEST(*oracle.winding_number({std::nextafter(1.0, 0.0), 0.25, 0.5}) == 1);
    BOOST_TEST(*oracle.winding_number({std::nextafter(1.0, 2.0), 0.25, 0.5}) == 0);
    BOOST_TEST(*oracle.winding_number({0.25, std::nextafter(1.0, 0.0), 0.5}) == 1);
    BOOST_TEST(*oracle.winding_number({0.25, std::nextafter(1.0, 2.0), 0.5}) == 0);
}

BOOST_AUTO_TEST_CASE(degenerate_faces_change_no_sign_but_are_surface) {
    const Mesh plain = cube(1);
    std::vector<Triangle> triangles = plain.triangles();
    std::vector<Vec3> vertices = plain.vertices();
    vertices.push_back({1, 1, 1});  // equal to vertex 7
    vertices.push_back({0, 0, 0});
    triangles.push_back({7, 8, 3});  // a repeated vertex once equal coordinates are one
    triangles.push_back({0, 0, 5});
    triangles.push_back({0, 9, 7});  // collinear, through the cube's centre
    const Mesh mesh(vertices, triangles);
    const Oracle oracle(mesh);
    BOOST_TEST(*oracle.winding_number({0.5, 0.25, 0.125}) == 1);
    BOOST_TEST(*oracle.winding_number({-0.5, 0.25, 0.25}) == 1);
    BOOST_TEST(*oracle.winding_number({-3, 0.25, 0.25}) == 0);
    BOOST_TEST(!oracle.winding_number({0.25, 0.25, 0.25}).has_value());
}

BOOST_AUTO_TEST_CASE(nested_duplicated_and_reversed_shells_add_up) {
    const Mesh shell = cube(1);
    const auto count = static_cast<std::uint32_t>(shell.vertices().size());
    const auto with_second = [&](double scale, bool reversed) {
        std::vector<Vec3> vertices = shell.vertices();
        std::vector<Triangle> triangles = shell.triangles();
        for (const Vec3& v : shell.vertices()) {
            vertices.push_back({scale * v[0], scale * v[1], scale * v[2]});
        }
        for (const Triangle& t : shell.triangles()) {
            triangles.push_back({t[0] + count, t[reversed ? 2 : 1] + count, t[reversed ? 1 : 2] + count});
        }
        return Mesh(vertices, triangles);
    };
    BOOST_TEST(*Oracle(with_second(0.5, false)).winding_number({0.1, 0.2, 0.3}) == 2);
    BOOST_TEST(*Oracle(with_second(0.5, true)).winding_number({0.1, 0.2, 0.3}) == 0);
    BOOST_TEST(*Oracle(with_second(0.5, true)).winding_number({0.7, 0.7, 0.7}) == 1);
    BOOST_TEST(*Oracle(with_second(1, false)).winding_number({0.1, 0.2, 0.3}) == 2);
    BOOST_TEST(*Oracle(with_second(1, false)).crossings({0.1, 0.2, 0.3}) == 2);
    BOOST_TEST(*Oracle(with_second(1, true)).winding_number({0.1, 0.2, 0.3}) == 0);
}

BOOST_AUTO_TEST_CASE(far_from_the_origin_and_at_tiny_scales_the_sign_is_exact) {
    const Mesh plain = b2().mesh;
    for (const auto& [scale, offset] : {std::pair{1.0, 0.0}, {1e-20, 0.0}, {1e20, 0.0}, {1e-300, 0.0}, {1.0, 1e9}}) {
        BOOST_TEST_CONTEXT("scale " << scale << " offset " << offset) {
            std::vector<Vec3> vertices = plain.vertices();
            const auto move = [s = scale, o = offset](const Vec3& p) {
                return Vec3{s * p[0] + o, s * p[1] + o, s * p[2] + o};
            };
            for (Vec3& vertex : vertices) {
                vertex = move(vertex);
            }
            const Mesh mesh(vertices, plain.triangles());
            const Oracle oracle(mesh);
            BOOST_TEST(*oracle.winding_number(move({-1.2, -1, -0.45})) ==
                       *Oracle(plain).winding_number({-1.2, -1, -0.45}));
            BOOST_TEST(*oracle.winding_number(move({-1.25, -1, -0.5})) ==
                       *Oracle(plain).winding_number({-1.25, -1, -0.5}));
            BOOST_TEST(*oracle.winding_number(move({0.75, 0.5, 0.25})) == 0);
        }
    }
    expect_solid_angles(plain, {-1.2, -1, -0.45});
}

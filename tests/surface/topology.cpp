#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "support/throws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf {

using test::check_throws;

namespace {

Topology topology_of(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
    return describe_topology(Mesh(vertices, triangles));
}

Triangle flipped(const Triangle& triangle) {
    return {triangle[0], triangle[2], triangle[1]};
}

SignRule resolved(const Topology& topology) {
    return resolve_sign_rule(SignRule::automatic, topology).rule;
}

/// A band of n x m quadrilaterals whose ends are joined; with `mirrored`, one end is mirrored across the band; with
/// `tube`, the band is closed across, too. The coordinates only need to differ.
Mesh strip(std::uint32_t n, std::uint32_t m, bool mirrored, bool tube) {
    const std::uint32_t columns = tube ? m : m + 1;
    std::vector<Vec3> vertices;
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const auto x = static_cast<double>(i);
            const auto y = static_cast<double>(j);
            vertices.push_back({x, y, x * x + y * y * y});
        }
    const auto vertex = [&](std::uint32_t i, std::uint32_t j) {
        if (tube) j %= m;
        if (i == n && mirrored) j = (tube ? 2 * m - j : m - j) % columns;
        return i % n * columns + j;
    };
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < m; ++j) {
            triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
            triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        }
    return Mesh(vertices, triangles);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_hole_of_one_triangle_has_three_open_edges) {
    Mesh sphere = make_shape("sphere3");
    std::vector<Triangle> triangles = sphere.triangles();
    const Triangle hole = triangles[100];
    triangles.erase(triangles.begin() + 100);
    const Topology topology = topology_of(sphere.vertices(), triangles);
    BOOST_TEST(!topology.closed);
    BOOST_TEST(!topology.balanced);
    BOOST_TEST(topology.open_edges == 3U);
    BOOST_TEST(topology.unbalanced_edges == 3U);
    BOOST_TEST(topology.non_manifold_edges == 0U);
    BOOST_REQUIRE(topology.first_open_edges.size() == 3U);
    for (const Topology::Edge& edge : topology.first_open_edges) {
        const auto is_corner = [&](const Vec3& point) {
            return std::any_of(hole.begin(), hole.end(), [&](auto index) { return sphere.vertices()[index] == point; });
        };
        BOOST_TEST(is_corner(edge.from));
        BOOST_TEST(is_corner(edge.to));
    }
    BOOST_CHECK(resolved(topology) == SignRule::solid_angle);
}

BOOST_AUTO_TEST_CASE(the_first_open_edges_are_those_of_the_first_triangles) {
    // Ten triangles apart from one another.
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t t = 0; t < 10; ++t) {
        const double x = 100.0 - 10.0 * t;
        vertices.insert(vertices.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    // The order of the vertices is no matter.
    std::reverse(vertices.begin(), vertices.end());
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) index = 29 - index;
    const Topology topology = topology_of(vertices, triangles);
    BOOST_TEST(topology.open_edges == 30U);
    BOOST_REQUIRE(topology.first_open_edges.size() == 5U);
    BOOST_CHECK((topology.first_open_edges[0].from == Vec3{100, 0, 0}));
    for (std::size_t k = 0; k < 5; ++k) BOOST_TEST(topology.first_open_edges[k].from[0] >= (k < 3 ? 100 : 90));
}

BOOST_AUTO_TEST_CASE(a_moebius_strip_is_open_and_a_klein_bottle_closed_but_not_balanced) {
    const Topology annulus = describe_topology(strip(12, 3, false, false));
    BOOST_TEST(annulus.open_edges == 24U);
    BOOST_TEST(annulus.unbalanced_edges == 24U);
    const Topology moebius = describe_topology(strip(12, 3, true, false));
    BOOST_TEST(moebius.open_edges == 24U);
    BOOST_TEST(moebius.unbalanced_edges == 27U);
    const Topology torus = describe_topology(strip(12, 5, false, true));
    BOOST_TEST(torus.balanced);
    const Topology klein = describe_topology(strip(12, 5, true, true));
    BOOST_TEST(klein.closed);
    BOOST_TEST(!klein.balanced);
    BOOST_TEST(klein.unbalanced_edges == 5U);
    BOOST_TEST(klein.open_edges == 0U);
    BOOST_CHECK(resolved(klein) == SignRule::parity);
}

BOOST_AUTO_TEST_CASE(an_edge_may_have_three_or_four_faces) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    const Topology three = topology_of(vertices, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
    BOOST_TEST(three.non_manifold_edges == 1U);
    BOOST_TEST(three.open_edges == 7U);
    BOOST_TEST(three.unused_vertices == 1U);
    const Topology four = topology_of(vertices, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}});
    BOOST_TEST(four.non_manifold_edges == 1U);
    BOOST_TEST(four.open_edges == 8U);
    BOOST_TEST(four.unbalanced_edges == 8U);
    const Topology uneven = topology_of(vertices, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {1, 0, 5}});
    BOOST_TEST(uneven.open_edges == 8U);
    BOOST_TEST(uneven.unbalanced_edges == 9U);
}

BOOST_AUTO_TEST_CASE(a_face_too_many_at_one_edge_does_not_stand_for_one_that_lacks_at_another) {
    // From vertex 0, edges leave to 1 and 2; both that arrive come from 1.
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const Topology topology = topology_of(vertices, {{0, 1, 3}, {0, 2, 1}, {3, 1, 0}});
    BOOST_TEST(topology.non_manifold_edges == 1U);
    BOOST_TEST(topology.open_edges == 3U);
    BOOST_TEST(topology.unbalanced_edges == 3U);
}

BOOST_AUTO_TEST_CASE(two_cones_that_share_only_their_tip_are_closed_and_balanced) {
    const std::vector<Vec3> vertices{{0, 0, 0},  {1, 0, 1},   {-1, 1, 1},  {-1, -1, 1},
                                     {1, 0, -1}, {-1, 1, -1}, {-1, -1, -1}};
    const Topology topology =
        topology_of(vertices, {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}, {4, 6, 5}});
    BOOST_TEST(topology.closed);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.non_manifold_edges == 0U);
    BOOST_TEST(!topology.inside_out);
}

BOOST_AUTO_TEST_CASE(a_face_that_comes_twice_counts_once_also_with_its_opposite) {
    const Mesh cube = make_shape("cube");
    std::vector<Triangle> same = cube.triangles();
    same.push_back(same[4]);
    const Topology twice = topology_of(cube.vertices(), same);
    BOOST_TEST(twice.balanced);
    BOOST_TEST(twice.open_edges == 0U);
    BOOST_TEST(twice.unbalanced_edges == 0U);
    BOOST_TEST(twice.non_manifold_edges == 3U);
    std::vector<Triangle> opposite = cube.triangles();
    opposite.push_back(flipped(opposite[4]));
    const Topology cancelled = topology_of(cube.vertices(), opposite);
    BOOST_TEST(cancelled.balanced);
    BOOST_TEST(cancelled.uncounted_faces == 1U);
}

BOOST_AUTO_TEST_CASE(a_pair_of_opposite_faces_encloses_nothing_but_is_balanced) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const Topology opposite = topology_of(vertices, {{0, 1, 2}, {0, 2, 1}});
    BOOST_TEST(opposite.balanced);
    BOOST_TEST(!opposite.inside_out);
    const Topology same = topology_of(vertices, {{0, 1, 2}, {1, 2, 0}});
    BOOST_TEST(!same.closed);
    BOOST_TEST(same.boundary_edges == 3U);
}

BOOST_AUTO_TEST_CASE(a_sheet_with_two_sides_encloses_nothing_however_it_is_rounded) {
    // A tilted fan and its reverse; the volume is rounding error, of either sign.
    for (std::uint32_t n = 3; n < 60; ++n) {
        BOOST_TEST_CONTEXT(n << " blades") {
            std::vector<Vec3> vertices{{0.1, 0.2, 0.3}};
            std::vector<Triangle> triangles;
            for (std::uint32_t i = 0; i < n; ++i) {
                const double angle = 2 * 3.14159265358979323846 * i / n;
                vertices.push_back({std::cos(angle), std::sin(angle), 0.7 * std::cos(angle) - 0.3 * std::sin(angle)});
                const std::uint32_t next = 1 + (i + 1) % n;
                triangles.insert(triangles.end(), {{0, i + 1, next}, {next, i + 1, 0}});
            }
            const Topology topology = topology_of(vertices, triangles);
            BOOST_TEST(topology.balanced);
            BOOST_TEST(!topology.inside_out);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_that_comes_twice_is_still_balanced) {
    const Mesh cube = make_shape("cube");
    std::vector<Triangle> twice = cube.triangles();
    twice.insert(twice.end(), cube.triangles().begin(), cube.triangles().end());
    const Topology topology = topology_of(cube.vertices(), twice);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.non_manifold_edges == 18U);
}

BOOST_AUTO_TEST_CASE(inside_out_is_a_matter_of_the_enclosed_volume) {
    for (const char* name : {"nested", "cube", "plate1e-6", "needle", "knot"})
        for (const double scale : {1.0, 1e-20, 1e20, 1e-300, 1e300})
            for (const double shift : {0.0, 1e3}) {
                BOOST_TEST_CONTEXT(name << " scaled by " << scale << " and moved by " << shift) {
                    const Mesh shape = make_shape(name);
                    std::vector<Vec3> vertices = shape.vertices();
                    for (Vec3& vertex : vertices)
                        for (double& x : vertex) x = (x + shift) * scale;
                    std::vector<Triangle> triangles = shape.triangles();
                    BOOST_TEST(!topology_of(vertices, triangles).inside_out);
                    std::transform(triangles.begin(), triangles.end(), triangles.begin(), flipped);
                    const Topology topology = topology_of(vertices, triangles);
                    BOOST_TEST(topology.balanced);
                    // A needle of 1e-6 at 1e3 keeps four digits of its width.
                    BOOST_TEST(topology.inside_out);
                    BOOST_CHECK(resolved(topology) == SignRule::nonzero);
                }
            }
}

BOOST_AUTO_TEST_CASE(one_flipped_face_is_turned_around) {
    const Mesh sphere = make_shape("sphere2");
    std::vector<Triangle> triangles = sphere.triangles();
    triangles[17] = flipped(triangles[17]);
    const Topology topology = topology_of(sphere.vertices(), triangles);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.reoriented_faces == 1U);
    BOOST_TEST(topology.first_unbalanced_edges.empty());
    BOOST_CHECK(resolved(topology) == SignRule::nonzero);
}

BOOST_AUTO_TEST_CASE(equal_coordinates_count_as_one_vertex) {
    const Mesh sphere = make_shape("sphere3");
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& triangle : sphere.triangles()) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        triangles.push_back({first, first + 1, first + 2});
        for (const std::uint32_t index : triangle) vertices.push_back(sphere.vertices()[index]);
    }
    const Topology topology = topology_of(vertices, triangles);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.coincident_vertices == vertices.size() - sphere.vertices().size());
    BOOST_TEST(topology.unused_vertices == 0U);
}

BOOST_AUTO_TEST_CASE(faces_that_repeat_a_vertex_drop_out_and_faces_without_area_stay) {
    const Mesh cube = make_shape("cube");
    std::vector<Vec3> vertices = cube.vertices();
    vertices.push_back(vertices[3]);
    std::vector<Triangle> triangles = cube.triangles();
    triangles.insert(triangles.end(), {{0, 0, 5}, {3, 8, 1}, {2, 2, 2}});
    const Topology topology = topology_of(vertices, triangles);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.repeated_vertex_faces == 3U);
    BOOST_TEST(topology.coincident_vertices == 1U);

    const Topology collinear = topology_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
    BOOST_TEST(collinear.open_edges == 3U);
    BOOST_TEST(collinear.repeated_vertex_faces == 0U);
    const Topology point = topology_of({{1, 2, 3}}, {{0, 0, 0}});
    BOOST_TEST(point.closed);
    BOOST_TEST(point.repeated_vertex_faces == 1U);
    BOOST_TEST(!point.inside_out);
}

BOOST_AUTO_TEST_CASE(unused_vertices_are_counted_and_otherwise_ignored) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Mesh cube = make_shape("cube");
    std::vector<Vec3> vertices = cube.vertices();
    for (int i = 0; i < 1000; ++i) vertices.push_back({nan, 0, 0});
    vertices.push_back(vertices[0]);
    const Topology topology = topology_of(vertices, cube.triangles());
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.unused_vertices == 1001U);
    BOOST_TEST(topology.coincident_vertices == 0U);
}

BOOST_AUTO_TEST_CASE(a_rule_that_the_mesh_cannot_honour_is_an_error_with_the_count) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const Topology open = topology_of(vertices, {{0, 1, 2}});
    check_throws(ErrorCode::invalid_mesh, {"nonzero", "3 unbalanced edges", "(0, 0, 0) to (1, 0, 0)", "none"},
                 [&] { resolve_sign_rule(SignRule::nonzero, open); });
    check_throws(ErrorCode::invalid_mesh, {"parity", "3 open edges", "(0, 0, 0) to (1, 0, 0)"},
                 [&] { resolve_sign_rule(SignRule::parity, open); });
    const ResolvedSignRule automatic = resolve_sign_rule(SignRule::automatic, open);
    BOOST_CHECK(automatic.rule == SignRule::none);
    BOOST_TEST(automatic.warning.find("3 open edges: (0, 0, 0) to (1, 0, 0)") != std::string::npos);
    BOOST_CHECK(resolve_sign_rule(SignRule::none, open).rule == SignRule::none);
    BOOST_TEST(resolve_sign_rule(SignRule::none, open).warning.empty());

    const Topology unbalanced = describe_topology(strip(12, 5, true, true));
    check_throws(ErrorCode::invalid_mesh, {"5 unbalanced edges", "parity and solid-angle would do"},
                 [&] { resolve_sign_rule(SignRule::nonzero, unbalanced); });
    BOOST_CHECK(resolve_sign_rule(SignRule::parity, unbalanced).rule == SignRule::parity);
    BOOST_TEST(resolve_sign_rule(SignRule::parity, unbalanced).warning.empty());
    BOOST_TEST(resolve_sign_rule(SignRule::automatic, unbalanced).warning.find("parity") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_sound_mesh_needs_no_warning_and_an_inside_out_one_gets_one) {
    const Mesh cube = make_shape("cube");
    const Topology sound = describe_topology(cube);
    for (const SignRule rule : {SignRule::automatic, SignRule::nonzero, SignRule::parity, SignRule::none})
        BOOST_TEST(resolve_sign_rule(rule, sound).warning.empty());
    std::vector<Triangle> triangles = cube.triangles();
    std::transform(triangles.begin(), triangles.end(), triangles.begin(), flipped);
    const ResolvedSignRule rule = resolve_sign_rule(SignRule::automatic, topology_of(cube.vertices(), triangles));
    BOOST_CHECK(rule.rule == SignRule::nonzero);
    BOOST_TEST(rule.warning.find("inside out") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(sign_rules_have_names) {
    for (const SignRule rule :
         {SignRule::automatic, SignRule::nonzero, SignRule::parity, SignRule::none, SignRule::solid_angle})
        BOOST_TEST(name_of(rule) != std::string("unknown"));
    BOOST_TEST(name_of(SignRule::automatic) == std::string("auto"));
    BOOST_TEST(name_of(SignRule::solid_angle) == std::string("solid-angle"));
}

}  // namespace clsdf

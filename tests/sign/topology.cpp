#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/same_topology.hpp"
#include "support/throws.hpp"

#include <cmath>
#include <numbers>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The topology of a mesh with the warnings, and its field, which must be right at every sample.
struct Outcome {
    SignRule rule = SignRule::none;
    std::string warnings;
    Field field;
};

Outcome compute_right(const Mesh& mesh, SignRule asked = SignRule::automatic) {
    Outcome outcome;
    DistanceTransform transform(test_device(), mesh, {.sign = asked},
                                {.log = [&](const std::string& message) { outcome.warnings += message; }});
    outcome.rule = transform.sign();
    const Grid grid = grid_around(mesh, 36, 5);
    outcome.field = transform.compute(grid, Band::symmetric(3 * grid.voxel()), Output::triangle);
    BOOST_TEST(check_exact(mesh, outcome.field).band_samples > 0U);
    return outcome;
}

std::size_t count_inside(const Field& field) {
    std::size_t count = 0;
    for (const float distance : field.distance())
        if (std::signbit(distance)) ++count;
    return count;
}

void check_rule(const Mesh& mesh, SignRule expected, const std::string& warning) {
    BOOST_TEST_CONTEXT(mesh.name()) {
        const Outcome outcome = compute_right(mesh);
        BOOST_TEST(name_of(outcome.rule) == name_of(expected));
        BOOST_TEST(outcome.warnings.find(warning) != std::string::npos, "the warning: " << outcome.warnings);
        BOOST_TEST((outcome.warnings.empty() == warning.empty()));
        BOOST_TEST(((count_inside(outcome.field) > 0) == (expected != SignRule::none)));
    }
}

Mesh flipped(const Mesh& mesh, std::size_t index) {
    std::vector<Triangle> triangles = mesh.triangles();
    std::swap(triangles[index][1], triangles[index][2]);
    return {mesh.vertices(), std::move(triangles), mesh.name() + " with a flipped face"};
}

Mesh with_faces(const Mesh& mesh, const std::vector<Triangle>& more, std::string name) {
    std::vector<Triangle> triangles = mesh.triangles();
    triangles.insert(triangles.end(), more.begin(), more.end());
    return {mesh.vertices(), std::move(triangles), std::move(name)};
}

Mesh half_sphere() {
    const Mesh sphere = make_shape("sphere3");
    std::vector<Triangle> triangles;
    for (const Triangle& t : sphere.triangles())
        if (sphere.vertices()[t[0]][2] + sphere.vertices()[t[1]][2] + sphere.vertices()[t[2]][2] > 0)
            triangles.push_back(t);
    return {sphere.vertices(), std::move(triangles), "half sphere"};
}

/// The figure-eight immersion: closed, not orientable, intersecting itself.
Mesh klein_bottle(std::uint32_t around, std::uint32_t across) {
    std::vector<Vec3> vertices;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * (j + 0.25) / across;
            const double c = std::cos(u / 2), s = std::sin(u / 2);
            const double radius = 2 + c * std::sin(v) - s * std::sin(2 * v);
            vertices.push_back({radius * std::cos(u), radius * std::sin(u), s * std::sin(v) + c * std::sin(2 * v)});
        }
    // After one turn v runs backwards: the j-th vertex meets the one at -v.
    const auto at = [&](std::uint32_t i, std::uint32_t j) {
        j %= across;
        return i < around ? i * across + j : (2 * across - 1 - j) % across;
    };
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return {std::move(vertices), std::move(triangles), "Klein bottle"};
}

/// Two tetrahedra with one edge in common.
Mesh tetrahedra_at_an_edge() {
    return {{{0, 0, -1}, {0, 0, 1}, {1, -0.3, 0.1}, {1.1, 0.5, 0}, {-1, -0.4, 0}, {-1.2, 0.3, 0.2}},
            {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}, {0, 5, 1}, {0, 1, 4}, {0, 4, 5}, {1, 5, 4}},
            "two tetrahedra at an edge"};
}

/// A transform looks for edges that are not paired while it prepares the mesh, and counts only if there are any.
void check_description(const Mesh& mesh) {
    BOOST_TEST_CONTEXT(mesh.name()) {
        const DistanceTransform transform(test_device(), mesh);
        const Topology &found = transform.topology(), expected = describe_topology(mesh);
        BOOST_TEST(found.closed == expected.closed);
        BOOST_TEST(found.balanced == expected.balanced);
        BOOST_TEST(found.inside_out == expected.inside_out);
        BOOST_TEST(found.duplicate_faces == expected.duplicate_faces);
        BOOST_TEST(found.inner_wall_faces == expected.inner_wall_faces);
        BOOST_TEST(found.parts == expected.parts);
        BOOST_TEST(found.inward_parts == expected.inward_parts);
        BOOST_TEST(found.nested_parts == expected.nested_parts);
        check_same_counts(found, expected);
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_transform_describes_its_mesh_as_describe_topology_does) {
    const Mesh sphere = make_shape("sphere3");
    const Triangle face = sphere.triangles()[7];
    for (const Mesh& mesh :
         {sphere, reversed(sphere), unwelded(sphere), half_sphere(), without_triangle(sphere, 100), flipped(sphere, 5),
          unwelded(flipped(sphere, 5)), klein_bottle(12, 6), moebius_strip(20), tetrahedra_at_an_edge(), cone(40),
          with_faces(sphere, {{0, 0, 1}}, "a face with a vertex twice"),
          with_faces(sphere, {{3, 3, 3}}, "a face of one vertex"), with_faces(sphere, {face}, "a face twice"),
          with_faces(sphere, {face, {face[0], face[2], face[1]}}, "a face three times, once turned around")})
        check_description(mesh);
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        Random random(seed);
        BOOST_TEST_CONTEXT("seed " << seed) {
            check_description(random_soup(random, 40, 100));
            check_description(unwelded(random_closed(random, 3)));
        }
    }
}

BOOST_AUTO_TEST_CASE(what_is_open_has_no_sign_unless_the_winding_number_is_clear) {
    check_rule(half_sphere(), SignRule::none, "not closed");
    check_rule(without_triangle(make_shape("sphere2"), 17), SignRule::solid_angle, "3 open edges");
    check_rule(moebius_strip(24), SignRule::none, "not closed");
    check_rule(with_faces(cube(1), {{0, 3, 2}}, "cube with the opposite of a face"), SignRule::nonzero, "counts once");
}

BOOST_AUTO_TEST_CASE(cracks_and_t_junctions_are_open) {
    Mesh cracked = cube(1);
    std::vector<Vec3> vertices = cracked.vertices();
    vertices.push_back({vertices[7][0] + 1e-7, vertices[7][1], vertices[7][2]});
    std::vector<Triangle> triangles = cracked.triangles();
    for (std::uint32_t& v : triangles.back())
        if (v == 7) v = 8;
    check_rule({vertices, triangles, "cube with a crack"}, SignRule::solid_angle, "not closed");

    vertices = cracked.vertices();
    vertices.push_back({0, 1, 1});
    triangles = cracked.triangles();
    triangles.erase(triangles.begin() + 3);
    triangles.insert(triangles.end(), {{4, 7, 8}, {4, 8, 6}});
    check_rule({vertices, triangles, "cube with a T-junction"}, SignRule::solid_angle, "not closed");
}

BOOST_AUTO_TEST_CASE(what_is_closed_but_not_oriented_alike_follows_parity) {
    check_rule(klein_bottle(28, 20), SignRule::parity, "not oriented alike");
}

BOOST_AUTO_TEST_CASE(what_can_be_oriented_is_oriented) {
    check_rule(flipped(make_shape("sphere2"), 5), SignRule::nonzero, "1 face looks the wrong way");
    check_rule(flipped(tetrahedra_at_an_edge(), 2), SignRule::nonzero, "1 face looks the wrong way");
    check_rule(with_faces(cube(1), {{0, 2, 3}}, "cube with a face twice"), SignRule::nonzero, "there twice");
}

BOOST_AUTO_TEST_CASE(a_rule_the_mesh_cannot_honour_is_refused) {
    const auto refuse = [](const Mesh& mesh, SignRule rule, const char* edges) {
        check_throws(ErrorCode::invalid_mesh, {edges}, [&] { DistanceTransform(test_device(), mesh, {.sign = rule}); });
    };
    refuse(half_sphere(), SignRule::nonzero, "unbalanced");
    refuse(half_sphere(), SignRule::parity, "open");
    refuse(klein_bottle(12, 8), SignRule::nonzero, "unbalanced");
}

BOOST_AUTO_TEST_CASE(solids_that_touch_are_solids) {
    check_rule(tetrahedra_at_an_edge(), SignRule::nonzero, "");
    check_rule(together({tetrahedra_at_an_edge(), shifted(cube(0.5), {1.61, 1, 0.5})}, "touching solids"),
               SignRule::nonzero, "");
    // Two cones that share their tip.
    const Mesh above = shifted(reversed(moved(cone(12),
                                              [](const Vec3& v) {
                                                  return Vec3{v[0], v[1], -v[2]};
                                              })),
                               {0, 0, 2});
    check_rule(weld(together({cone(12), above}, "two cones")), SignRule::nonzero, "");
    // Box beside box, with a wall in common: a face of either orientation lies inside the solid.
    check_rule(weld(together({box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1})}, "two boxes")), SignRule::nonzero,
               "");
}

// With parity, regions that are covered twice are outside.
BOOST_AUTO_TEST_CASE(a_surface_given_twice_encloses_twice) {
    const Mesh twice = together({tilted(cube(1)), tilted(cube(1))}, "cube given twice");
    BOOST_TEST(count_inside(compute_right(twice, SignRule::nonzero).field) > 0U);
    BOOST_TEST(count_inside(compute_right(twice, SignRule::parity).field) == 0U);
}

BOOST_AUTO_TEST_CASE(a_surface_and_its_opposite_are_one_body) {
    const Mesh both = together({tilted(cube(1)), reversed(tilted(cube(1)))}, "cube and its opposite");
    const Outcome outcome = compute_right(both);
    BOOST_TEST(name_of(outcome.rule) == "nonzero");
    BOOST_TEST(outcome.warnings.find("on both sides") != std::string::npos);
    BOOST_TEST(count_inside(outcome.field) == count_inside(compute_right(tilted(cube(1))).field));
    BOOST_TEST(count_inside(compute_right(plate(0)).field) == 0U);
}

BOOST_AUTO_TEST_CASE(a_face_and_its_opposite_change_nothing_of_a_solid) {
    check_rule(with_faces(tilted(cube(1)), {{0, 2, 3}, {0, 3, 2}}, "cube with a folded face"), SignRule::nonzero, "");
    // The fin between two opposite corners lies inside, its distance counts.
    check_rule(with_faces(tilted(cube(1)), {{0, 7, 1}, {0, 1, 7}}, "cube with a fin"), SignRule::nonzero, "");
}

// Samples in the planes of faces, in line with edges and with vertices; parity tells a crossing that was counted twice.
BOOST_AUTO_TEST_CASE(rows_through_edges_and_vertices_cross_them_once) {
    for (const Mesh& mesh : {cube(1), make_shape("sphere0"), make_shape("sphere1")})
        for (const SignRule rule : {SignRule::nonzero, SignRule::parity})
            check_exact(mesh, compute(mesh, grid_at({0, 0, 0}, 0.125, 12), Band::symmetric(0.3), rule));
}

BOOST_AUTO_TEST_CASE(shells_within_shells_have_the_sign_of_their_rule) {
    const auto shell = [](double size) { return scaled(tilted(make_shape("sphere1")), size); };
    const Mesh alike = together({shell(1), shell(0.6), shell(0.3)}, "three shells");
    const Mesh hollow = together({shell(1), reversed(shell(0.6)), shell(0.3)}, "hollow sphere with a core");
    const Field solid = compute_right(alike, SignRule::nonzero).field;
    const Field layered = compute_right(alike, SignRule::parity).field;
    const Field cavity = compute_right(hollow).field;
    const auto is_inside = [](const Field& field, double x) {
        const Grid& grid = field.grid;
        const auto i = std::llround((x - grid.origin[0]) / grid.spacing[0]);
        return std::signbit(field.distance()[grid.offset(i, grid.size[1] / 2, grid.size[2] / 2)]);
    };
    BOOST_TEST(is_inside(solid, 0));
    BOOST_TEST(is_inside(solid, 0.42));
    BOOST_TEST(is_inside(layered, 0));
    BOOST_TEST(!is_inside(layered, 0.42));
    BOOST_TEST(count_inside(cavity) == count_inside(layered));
}

BOOST_AUTO_TEST_CASE(solids_that_intersect_are_exact) {
    const Mesh sphere = tilted(make_shape("sphere2"));
    const Mesh pair = together({sphere, shifted(sphere, {0.9, 0.3, -0.2})}, "overlapping spheres");
    check_rule(pair, SignRule::nonzero, "2 of 2 parts are partly within others");
    // Points inside both parts are outside by parity.
    BOOST_TEST(count_inside(compute_right(pair, SignRule::parity).field) < count_inside(compute_right(pair).field));
    // A ring so thick that it touches and intersects itself.
    check_rule(moved(make_shape("torus"),
                     [](const Vec3& v) {
                         const double radius = std::hypot(v[0], v[1]);
                         return Vec3{v[0] * (1 - 0.9 / radius), v[1] * (1 - 0.9 / radius), v[2]};
                     }),
               SignRule::nonzero, "");
}

BOOST_AUTO_TEST_CASE(what_a_mesh_that_is_inside_out_encloses_is_inside) {
    for (const char* name : {"sphere2", "knot"}) {
        const Mesh mesh = make_shape(name);
        const Outcome outcome = compute_right(reversed(mesh));
        BOOST_TEST(outcome.warnings.find("inside out") != std::string::npos);
        BOOST_TEST(count_inside(outcome.field) == count_inside(compute_right(mesh).field));
    }
}

BOOST_AUTO_TEST_CASE(a_thousand_components_are_exact) {
    std::vector<Mesh> drops;
    drops.reserve(1000);
    Random random(7);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 place = random.point(-1, 1);
        const double size = random.uniform(0.01, 0.08), angle = random.uniform(0, 3);
        drops.push_back(shifted(scaled(tilted(make_shape("sphere0"), angle), size), place));
    }
    // Some lie within others.
    check_rule(together(drops, "a thousand drops"), SignRule::nonzero, "within others and look");
}

BOOST_AUTO_TEST_CASE(a_triangle_alone_has_a_distance) {
    check_rule({{{0.1, 0.2, 0.3}, {1.2, 0.1, 0}, {0.4, 1.3, 0.5}}, {{0, 1, 2}}, "triangle"}, SignRule::none,
               "not closed");
}

BOOST_AUTO_TEST_CASE(a_triangle_without_area_is_a_segment_or_a_point) {
    const auto check = [](const Mesh& mesh) {
        for (const double reach : {3.0, 1e9})
            BOOST_TEST(
                check_exact(mesh, compute(mesh, grid_at({0.3, 0.2, 0.1}, 0.1, 12), Band::symmetric(reach)), guaranteed)
                    .band_samples > 0U);
    };
    check({{{0.31, 0.22, 0.13}, {0.31, 0.22, 0.13}, {0.31, 0.22, 0.13}}, {{0, 1, 2}}, "three equal points"});
    check({{{0.31, 0.22, 0.13}}, {{0, 0, 0}}, "one point thrice"});
    check({{{0, 0, 0}, {0.5, 0.25, 0.125}, {1, 0.5, 0.25}}, {{0, 1, 2}}, "three points on a line"});
    check({{{0, 0, 0}, {1, 0.5, 0.25}, {0.5, 0.25, 0.125}}, {{0, 1, 2}}, "a fold"});
    check({{{0, 0, 0}, {1, 0.5, 0.25}}, {{0, 1, 1}}, "segment"});
    check({{{0, 0, 0}, {1, 0.5, 0.25}, {std::nextafter(1, 2), 0.5, 0.25}}, {{0, 1, 2}}, "an ulp wide"});
}

// Corners on a line, exactly or but for the rounding of their coordinates.
BOOST_AUTO_TEST_CASE(soups_of_triangles_without_area_are_exact) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            std::vector<Vec3> vertices;
            std::vector<Triangle> triangles;
            for (std::uint32_t i = 0; i < 40; ++i) {
                const double step = seed % 2 == 0 ? 0.125 : 1.0 / 7;
                const auto lattice_point = [&] {
                    return Vec3{step * std::round(random.uniform(-6, 6)), step * std::round(random.uniform(-6, 6)),
                                step * std::round(random.uniform(-6, 6))};
                };
                const Vec3 from = lattice_point(), direction = lattice_point();
                const double farthest = 1.0 + random.index(3);
                vertices.insert(vertices.end(), {from, along(from, 0.5, direction), along(from, farthest, direction)});
                const std::uint32_t turn = random.index(3);
                triangles.push_back({3 * i + turn, 3 * i + (turn + 1) % 3, 3 * i + (turn + 2) % 3});
            }
            const Mesh mesh(vertices, triangles, "segments");
            const Grid grid = grid_around(mesh, 28, 3);
            check_exact(mesh, grid, Band::symmetric(3 * grid.voxel()));
            check_exact(mesh, grid, Band::full(), guaranteed);
        }
}

BOOST_AUTO_TEST_CASE(degenerate_faces_of_a_solid_change_nothing) {
    const Mesh solid = tilted(cube(1));
    std::vector<Vec3> vertices = solid.vertices();
    Vec3 middle{};
    for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] = 0.5 * (vertices[0][axis] + vertices[1][axis]);
    vertices.push_back(middle);
    std::vector<Triangle> triangles = solid.triangles();
    triangles.insert(triangles.end(), {{3, 3, 3}, {0, 1, 0}, {0, 8, 1}, {0, 1, 8}});
    check_rule({vertices, triangles, "cube with degenerate faces"}, SignRule::nonzero, "");
}

// Three faces at an edge: its ends need a polyhedron each, more than room is left for at first.
BOOST_AUTO_TEST_CASE(books_whose_spines_outnumber_their_pages_are_right) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < 100; ++i) {
        const double x = 20.0 * (i % 5);
        const double y = 20.0 * (i / 5 % 5);
        const double z = 20.0 * (i / 25);
        vertices.insert(vertices.end(),
                        {{x, y, z - 5}, {x, y, z + 5}, {x + 9, y, z}, {x - 5, y + 8, z}, {x - 5, y - 8, z}});
        for (const std::uint32_t page : {2U, 3U, 4U}) triangles.push_back({5 * i, 5 * i + 1, 5 * i + page});
    }
    compute_right({std::move(vertices), std::move(triangles), "books"});
}

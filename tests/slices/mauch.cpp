#include "slices/mauch_pieces.hpp"
#include "slices/scanned.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"
#include "transform/layout_of.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Exact, with no empty intersection.
Scanned check_mauch(const Mesh& mesh, const Grid& grid, const Band& band, const Accuracy& accuracy = aimed,
                    TransformOptions options = {}) {
    options.polyhedra = Polyhedra::mauch;
    Scanned scanned = scan_slices(mesh, grid, band, std::move(options));
    const reference::CheckReport report = check_exact(mesh, scanned.field, accuracy);
    BOOST_TEST(report.band_samples > 0U, "nothing of " << mesh.name() << " is in the band");
    check_intersections(scanned.statistics);
    return scanned;
}

void check_at_some_widths(const Mesh& mesh, std::int64_t resolution, const TransformOptions& options = {}) {
    for (const double share : {0.02, 0.1}) {
        const Band band = Band::symmetric(share * mesh.box().longest_side());
        check_mauch(mesh, Grid::around(mesh, resolution, band), band, aimed, options);
    }
}

slices::MauchPieces pieces_of(const Mesh& mesh, double half_width) {
    const Grid grid = grid_around(mesh, 20, 2 + half_width);
    const Band band = Band::symmetric(half_width * grid.voxel());
    const Layout layout = transform::layout_of(grid, band, SignRule::none);
    return slices::mauch_pieces(mesh, transform::lattice_of(grid), half_width, layout);
}

/// Two faces at one edge, the second turned out of the first one's plane.
Mesh hinge(double angle) {
    return Mesh({{0, 0, 0}, {0, 4, 0}, {3, 2, 0}, {-3 * std::cos(angle), 2, 3 * std::sin(angle)}},
                {{0, 2, 1}, {0, 1, 3}}, "hinge");
}

/// A vertex surrounded by a zigzag of neighbours, all above its plane by `height` on average.
Mesh umbrella(std::size_t neighbours, double height) {
    std::vector<Vec3> vertices{{0, 0, 0}};
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < neighbours; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(neighbours);
        vertices.push_back({3 * std::cos(angle), 3 * std::sin(angle), height + 0.1 * static_cast<double>(i % 3)});
        triangles.push_back(
            {0, static_cast<std::uint32_t>(1 + i), static_cast<std::uint32_t>(1 + (i + 1) % neighbours)});
    }
    return Mesh(std::move(vertices), std::move(triangles), "umbrella");
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_counterexample_is_exact) {
    for (const Counterexample& example : all_counterexamples()) {
        const Band band = Band::symmetric(example.half_width);
        check_mauch(example.mesh, Grid::around(example.mesh, 40, band), band, guaranteed);
        const Vec3& known = example.samples.front().position;
        check_mauch(example.mesh, grid_at(known, example.half_width / 8, 7), band, guaranteed);
    }
}

BOOST_AUTO_TEST_CASE(cones_of_saddle_vertices_are_not_lost) {
    for (const Counterexample& example : {h1(), h2(), h3(), h4(), h5()})
        check_mauch(example.mesh, grid_at({0, 0, 0}, 0.125, 14), Band::symmetric(1), guaranteed);
    check_mauch(h6().mesh, grid_at({0, 0, 0}, 1, 24), Band::symmetric(20), guaranteed);
}

BOOST_AUTO_TEST_CASE(every_shape_is_exact) {
    for (const char* name : {"sphere0", "sphere1", "sphere4", "torus", "knot", "seashell", "stairs", "plate", "needle",
                             "tetrahedron", "noisy", "nested"})
        check_at_some_widths(make_shape(name), 36);
}

BOOST_AUTO_TEST_CASE(shapes_are_exact_by_groups) {
    for (const char* name : {"sphere1", "knot", "stairs", "needle"})
        check_at_some_widths(make_shape(name), 28, {.body = KernelBody::by_group});
}

BOOST_AUTO_TEST_CASE(shapes_are_exact_without_a_band) {
    for (const char* name : {"sphere2", "stairs", "needle", "nested"}) {
        const Mesh mesh = make_shape(name);
        for (const Band& band : {Band::full(), Band{infinite, 0.05 * mesh.box().longest_side()}})
            check_mauch(mesh, Grid::around(mesh, 26, band), band, guaranteed);
    }
}

BOOST_AUTO_TEST_CASE(random_meshes_are_exact) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            check_at_some_widths(tilted(random_flap(random), random.uniform(0, 3)), 32);
            check_at_some_widths(random_stairs(random, 4 + random.index(8)), 32);
            check_at_some_widths(random_sphere(random, "sphere2", 0.9), 28);
            check_at_some_widths(random_closed(random, 5), 28);
            check_at_some_widths(random_soup(random, 12, 60), 28);
            check_at_some_widths(random_slivers(random, 60), 28);
            const Mesh tetrahedron = random_lattice_tetrahedron(random, 0.5);
            if (tetrahedron.box().longest_side() > 0)
                check_mauch(tetrahedron, grid_around(tetrahedron, 24, 4), Band::symmetric(1));
        }
}

BOOST_AUTO_TEST_CASE(an_open_and_an_unwelded_mesh_are_exact) {
    check_at_some_widths(without_triangle(make_shape("knot"), 100), 32);
    check_at_some_widths(unwelded(make_shape("knot")), 32);
    check_at_some_widths(moebius_strip(60), 32);
}

BOOST_AUTO_TEST_CASE(a_vertex_of_very_many_neighbours_is_exact) {
    for (const std::size_t neighbours : {9U, 12U, 40U, 300U})
        for (const double height : {-0.4, 0.02, 2.0}) check_at_some_widths(umbrella(neighbours, height), 30);
}

BOOST_AUTO_TEST_CASE(hinges_of_every_angle_are_exact) {
    for (const double angle : {-3.1415926, -3.0, -1.5, -1e-3, -1e-9, 0.0, 1e-12, 1e-6, 0.2, 1.5, 2.8, 3.1415926})
        check_at_some_widths(tilted(hinge(angle)), 30);
}

BOOST_AUTO_TEST_CASE(unequal_spacing_is_exact) {
    const Mesh mesh = tilted(make_shape("torus"));
    for (const Vec3 ratio : {Vec3{1, 1, 40}, Vec3{1, 40, 1}, Vec3{40, 1, 1}, Vec3{1, 2.5, 7}, Vec3{1, 1.01, 0.99}}) {
        const double h = mesh.box().longest_side() / 100;
        GridOptions options;
        options.spacing = {h * ratio[0], h * ratio[1], h * ratio[2]};
        options.margin = Length::in_mesh_units(3 * h);
        const Grid around = Grid::around(mesh.box(), options);
        Index3 size{}, first{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            size[axis] = std::min<std::int64_t>(around.size[axis], 40);
            first[axis] = (around.size[axis] - size[axis]) / 4;
        }
        check_mauch(mesh, around.part(first, size), Band::symmetric(6 * h));
    }
}

BOOST_AUTO_TEST_CASE(large_triangles_are_exact) {
    for (const double size : {500.0, 1e6}) {
        const Mesh mesh({{0.3, -0.2, 0.4}, {0.8 * size, 0.3 * size, 0.5 * size}, {-0.2 * size, 0.6 * size, 0.7 * size}},
                        {{0, 1, 2}}, "large triangle");
        check_mauch(mesh, grid_at({0, 0, 0}, 1, 8), Band::symmetric(3));
        check_mauch(mesh, grid_at({0.4 * size, 0.15 * size, 0.25 * size}, 1, 8), Band::symmetric(3));
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_far_away_is_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = std::exp2(std::round(std::log2(mesh.box().longest_side() / 24)));
    const Mesh far = shifted(mesh, {1e6 * h, -0.7e6 * h, 0.3e6 * h});
    check_mauch(far, grid_around(far, 30, 3), Band::symmetric(3 * h));
}

// Of a closed convex surface every site has one; where faces meet in a plane there is nothing between them.
BOOST_AUTO_TEST_CASE(every_site_with_directions_of_its_own_has_a_polyhedron) {
    const slices::MauchPieces sphere = pieces_of(make_shape("sphere4"), 2);
    BOOST_TEST(sphere.towers == 2048U);
    BOOST_TEST(sphere.wedges == 3072U);
    BOOST_TEST(sphere.cones == 1026U);
    BOOST_TEST(sphere.boxes == 0U);

    const slices::MauchPieces box = pieces_of(cube(1), 2);
    BOOST_TEST(box.towers == 12U);
    BOOST_TEST(box.wedges == 12U);
    BOOST_TEST(box.cones == 8U);

    const slices::MauchPieces triangle = pieces_of(Mesh({{0, 0, 0}, {3, 0, 0}, {0, 2, 1}}, {{0, 1, 2}}), 2);
    BOOST_TEST(triangle.towers == 1U);
    BOOST_TEST(triangle.wedges == 3U);
    BOOST_TEST(triangle.cones == 3U);

    BOOST_TEST(pieces_of(hinge(0), 2).wedges == 4U);
    BOOST_TEST(pieces_of(hinge(0.1), 2).wedges == 5U);
}

// What the paper's own scan converted: about one and a tenth distances for each sample of a sphere's band.
BOOST_AUTO_TEST_CASE(few_samples_lie_in_more_than_one_polyhedron) {
    const Mesh mesh = make_shape("sphere4");
    const Band band = Band::symmetric(0.1 * mesh.box().longest_side());
    const TransformStatistics statistics = check_mauch(mesh, Grid::around(mesh, 60, band), band).statistics;
    BOOST_TEST(statistics.polyhedra == 2048U + 3072U + 1026U);
    BOOST_TEST(statistics.samples_covered >= statistics.band_samples);
    BOOST_TEST(static_cast<double>(statistics.samples_covered) < 1.15 * static_cast<double>(statistics.band_samples));
}

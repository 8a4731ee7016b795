#include "lattice/layout_of.hpp"
#include "papers/exact.hpp"
#include "papers/pieces.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <cmath>
#include <numbers>

using namespace clsdf;
using namespace clsdf::test;

namespace {

papers::MauchPieces pieces_of(const Mesh& mesh, double half_width) {
    const Grid grid = grid_around(mesh, 20, 2 + half_width);
    const Band band = Band::symmetric(half_width * grid.voxel());
    const Layout layout = engine::layout_of(grid, band, SignRule::none);
    return papers::mauch_pieces(mesh, engine::lattice_of(grid), half_width, layout);
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

BOOST_AUTO_TEST_CASE(a_vertex_of_very_many_neighbours_is_exact) {
    for (const std::size_t neighbours : {9U, 12U, 40U, 300U})
        for (const double height : {-0.4, 0.02, 2.0}) check_at_some_widths(umbrella(neighbours, height), 30);
}

BOOST_AUTO_TEST_CASE(hinges_of_every_angle_are_exact) {
    for (const double angle : {-3.1415926, -3.0, -1.5, -1e-3, -1e-9, 0.0, 1e-12, 1e-6, 0.2, 1.5, 2.8, 3.1415926})
        check_at_some_widths(tilted(hinge(angle)), 30);
}

// The slack of a tower whose walls meet at a small angle reaches far beyond the corner: here 0.1 of the least spacing.
BOOST_AUTO_TEST_CASE(the_rims_of_thin_crossed_plates_are_exact) {
    const Mesh mesh = together(
        {box({-0.05, -2.5e-7, -0.05}, {0.05, 2.5e-7, 0.05}), box({-0.1, -2.5e-7, -0.025}, {0.1, 2.5e-7, 0.025})},
        "plates");
    Grid grid = grid_at({0.15, 0, 0.0546}, 1, 3);
    grid.spacing[2] = 100;
    grid.origin[2] = 0.0546 - 300;
    check_scanned(mesh, grid, Band::symmetric(3), guaranteed);
}

// On a closed convex surface every site has one, but for edges between faces that lie in one plane.
BOOST_AUTO_TEST_CASE(every_site_with_directions_of_its_own_has_a_polyhedron) {
    const papers::MauchPieces sphere = pieces_of(make_shape("sphere4"), 2);
    BOOST_TEST(sphere.towers == 2048U);
    BOOST_TEST(sphere.wedges == 3072U);
    BOOST_TEST(sphere.cones == 1026U);
    BOOST_TEST(sphere.boxes == 0U);

    const papers::MauchPieces box = pieces_of(cube(1), 2);
    BOOST_TEST(box.towers == 12U);
    BOOST_TEST(box.wedges == 12U);
    BOOST_TEST(box.cones == 8U);

    const papers::MauchPieces triangle = pieces_of(Mesh({{0, 0, 0}, {3, 0, 0}, {0, 2, 1}}, {{0, 1, 2}}), 2);
    BOOST_TEST(triangle.towers == 1U);
    BOOST_TEST(triangle.wedges == 3U);
    BOOST_TEST(triangle.cones == 3U);

    BOOST_TEST(pieces_of(hinge(0), 2).wedges == 4U);
    BOOST_TEST(pieces_of(hinge(0.1), 2).wedges == 5U);
}

// As the paper's own scan: about 1.1 distances for each sample of a sphere's band.
BOOST_AUTO_TEST_CASE(few_samples_lie_in_more_than_one_polyhedron) {
    const Mesh mesh = make_shape("sphere4");
    const Band band = Band::symmetric(0.1 * mesh.box().longest_side());
    const TransformStatistics statistics = check_scanned(mesh, Grid::around(mesh, 60, band), band).statistics;
    BOOST_TEST(statistics.work->polyhedra == 2048U + 3072U + 1026U);
    BOOST_TEST(statistics.work->samples_covered >= statistics.work->band_samples);
    BOOST_TEST(static_cast<double>(statistics.work->samples_covered) <
               1.15 * static_cast<double>(statistics.work->band_samples));
}

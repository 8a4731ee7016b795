#include "papers/exact.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

// Tests of leaned and of Mauch's polyhedra alike: CLSDF_SCANNED says which are scanned.

using namespace clsdf;
using namespace clsdf::test;

BOOST_AUTO_TEST_CASE(every_counterexample_is_exact) {
    for (const Counterexample& example : all_counterexamples()) {
        const Band band = Band::symmetric(example.half_width);
        check_scanned(example.mesh, Grid::around(example.mesh, 40, band), band, guaranteed);
        const Vec3& known = example.samples.front().position;
        check_scanned(example.mesh, grid_at(known, example.half_width / 8, 7), band, guaranteed);
    }
}

BOOST_AUTO_TEST_CASE(directions_of_saddle_vertices_are_not_lost) {
    for (const Counterexample& example : {h1(), h2(), h3(), h4(), h5()})
        check_scanned(example.mesh, grid_at({0, 0, 0}, 0.125, 14), Band::symmetric(1), guaranteed);
    check_scanned(h6().mesh, grid_at({0, 0, 0}, 1, 24), Band::symmetric(20), guaranteed);
}

BOOST_AUTO_TEST_CASE(every_shape_is_exact) {
    for (const char* name : {"sphere0", "sphere1", "sphere4", "torus", "knot", "seashell", "stairs", "plate", "needle",
                             "tetrahedron", "noisy", "nested"})
        check_at_some_widths(make_shape(name), 36);
}

BOOST_AUTO_TEST_CASE(shapes_are_exact_by_groups) {
    for (const char* name : {"sphere1", "knot", "stairs", "needle"})
        check_at_some_widths(make_shape(name), 28, KernelBody::by_group);
}

BOOST_AUTO_TEST_CASE(shapes_are_exact_without_a_band) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    for (const char* name : {"sphere2", "stairs", "needle", "nested"}) {
        const Mesh mesh = make_shape(name);
        for (const Band& band : {Band::full(), Band{infinite, 0.05 * mesh.box().longest_side()}})
            check_scanned(mesh, Grid::around(mesh, 26, band), band, guaranteed);
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
                check_scanned(tetrahedron, grid_around(tetrahedron, 24, 4), Band::symmetric(1));
        }
}

BOOST_AUTO_TEST_CASE(an_open_and_an_unwelded_mesh_are_exact) {
    check_at_some_widths(without_triangle(make_shape("knot"), 100), 32);
    check_at_some_widths(unwelded(make_shape("knot")), 32);
    check_at_some_widths(moebius_strip(60), 32);
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
        check_scanned(mesh, around.part(first, size), Band::symmetric(6 * h));
    }
}

BOOST_AUTO_TEST_CASE(large_triangles_are_exact) {
    for (const double size : {500.0, 1e6}) {
        const Mesh mesh({{0.3, -0.2, 0.4}, {0.8 * size, 0.3 * size, 0.5 * size}, {-0.2 * size, 0.6 * size, 0.7 * size}},
                        {{0, 1, 2}}, "large triangle");
        check_scanned(mesh, grid_at({0, 0, 0}, 1, 8), Band::symmetric(3));
        check_scanned(mesh, grid_at({0.4 * size, 0.15 * size, 0.25 * size}, 1, 8), Band::symmetric(3));
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_far_away_is_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = std::exp2(std::round(std::log2(mesh.box().longest_side() / 24)));
    const Mesh far = shifted(mesh, {1e6 * h, -0.7e6 * h, 0.3e6 * h});
    check_scanned(far, grid_around(far, 30, 3), Band::symmetric(3 * h));
    Grid grid = grid_at({0, 0, 0}, h, 15);
    grid.first = {1000000000, -1000000000, 500000000};
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] -= h * static_cast<double>(grid.first[axis]);
    check_scanned(mesh, grid, Band::symmetric(3 * h));
}

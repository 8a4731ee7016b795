#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <cmath>

using namespace clsdf;
using namespace clsdf::test;

namespace {

Grid sized(const Mesh& mesh, double h, const Index3& size, const Index3& first) {
    Grid grid;
    grid.spacing = {h, h, h};
    grid.size = size;
    grid.first = first;
    // The block's centre is that of the mesh, for every first sample.
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.origin[axis] = 0.5 * (mesh.box().lower[axis] + mesh.box().upper[axis]) -
                            h * (static_cast<double>(first[axis]) + 0.5 * static_cast<double>(size[axis] - 1));
    return grid;
}

}  // namespace

BOOST_AUTO_TEST_CASE(thin_grids_are_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = mesh.box().longest_side() / 40;
    for (const Index3 size : {Index3{1, 37, 41}, Index3{37, 1, 41}, Index3{37, 41, 1}, Index3{53, 1, 1},
                              Index3{1, 53, 1}, Index3{1, 1, 53}})
        check_exact(mesh, sized(mesh, h, size, {0, 0, 0}), Band::symmetric(6 * h));
    const Field one = compute(mesh, sized(mesh, h, {1, 1, 1}, {0, 0, 0}), Band::full());
    check_exact(mesh, one);
}

BOOST_AUTO_TEST_CASE(sizes_of_any_kind_are_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = mesh.box().longest_side() / 24;
    for (const Index3 size : {Index3{7, 8, 9}, Index3{15, 16, 17}, Index3{31, 32, 33}, Index3{2, 40, 3}})
        check_exact(mesh, sized(mesh, h, size, {0, 0, 0}), Band::symmetric(3 * h));
}

BOOST_AUTO_TEST_CASE(a_first_sample_anywhere_is_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = mesh.box().longest_side() / 24;
    for (const Index3 first : {Index3{1, 2, 3}, Index3{-1, -7, -33}, Index3{-1000, 31, 100001}})
        check_exact(mesh, sized(mesh, h, {33, 21, 26}, first), Band::symmetric(3 * h));
}

BOOST_AUTO_TEST_CASE(a_grid_inside_the_mesh_and_far_from_its_surface_is_filled_with_the_inside) {
    const Mesh mesh = scaled(make_shape("sphere2"), 100);
    const Grid grid = grid_at({1, 2, 3}, 0.5, 9);
    const Field field = compute(mesh, grid, Band{2, 3});
    BOOST_TEST(check_exact(mesh, field).band_samples == 0U);
    for (const float distance : field.distance()) BOOST_REQUIRE(distance == -2.0F);
}

BOOST_AUTO_TEST_CASE(a_mesh_beside_the_grid_is_exact) {
    // Beyond each face of the grid in turn: far away, within the band, and touching it.
    const Grid grid = grid_at({0, 0, 0}, 0.25, 10);
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            for (const double gap : {100.0, 0.6, 0.0, -0.3}) {
                Vec3 by{0.1, 0.2, -0.1};
                by[axis] = side * (2.5 + 0.75 + gap);
                const Mesh mesh = shifted(cube(0.75), by);
                const Field field = compute(mesh, grid, Band::symmetric(1));
                BOOST_TEST((check_exact(mesh, field).band_samples > 0U) == (gap < 50));
            }
}

BOOST_AUTO_TEST_CASE(a_mesh_beside_the_grid_casts_its_sign_on_nothing) {
    // Between the mesh and the rows' beginning or end there is nothing but outside.
    const Grid grid = grid_at({0, 0, 0}, 0.25, 8);
    for (const double x : {-50.0, 50.0}) {
        const Field field = compute(shifted(cube(3), {x, 0, 0}), grid, Band::symmetric(0.5));
        for (const float distance : field.distance()) BOOST_REQUIRE(distance == 0.5F);
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_larger_than_the_grid_is_exact) {
    const Mesh mesh = scaled(make_shape("sphere3"), 20);
    for (const Vec3 centre : {Vec3{20, 0, 0}, Vec3{-3, 11, 16}, Vec3{0, 0, -20}})
        check_exact(mesh, grid_at(centre, 0.1, 16), Band::symmetric(0.7));
}

BOOST_AUTO_TEST_CASE(samples_beyond_the_lattices_reach_are_refused) {
    Grid grid = grid_at({0, 0, 0}, 1, 4);
    grid.first = {0, std::int64_t{1} << 30, 0};
    check_throws(ErrorCode::invalid_argument, {"2^30", "axis y"}, [&] { compute(cube(1), grid, Band::symmetric(1)); });
}

BOOST_AUTO_TEST_CASE(a_grid_that_makes_no_sense_is_refused) {
    const Mesh mesh = cube(1);
    const auto refuse = [&](const std::function<void(Grid&)>& spoil) {
        Grid grid = grid_at({0, 0, 0}, 0.5, 4);
        spoil(grid);
        check_throws(ErrorCode::invalid_argument, {}, [&] { compute(mesh, grid, Band::symmetric(1)); });
        check_throws(ErrorCode::invalid_argument, {},
                     [&] { DistanceTransform(test_device(), mesh).plan(grid, Band::symmetric(1)); });
    };
    refuse([](Grid& grid) { grid.size[1] = 0; });
    refuse([](Grid& grid) { grid.size[2] = -3; });
    refuse([](Grid& grid) { grid.spacing[0] = 0; });
    refuse([](Grid& grid) { grid.spacing[1] = -1; });
    refuse([](Grid& grid) { grid.spacing[2] = std::nan(""); });
    refuse([](Grid& grid) { grid.origin[0] = std::numeric_limits<double>::infinity(); });
}

BOOST_AUTO_TEST_CASE(a_mesh_farther_than_can_be_computed_is_refused) {
    const Mesh mesh = shifted(cube(1), {1e15, 0, 0});
    check_throws(ErrorCode::invalid_argument, {"1e14", "axis x"}, [&] {
        compute(mesh, grid_at({0, 0, 0}, 1, 4), Band::symmetric(1));
    });
}

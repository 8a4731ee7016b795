#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A triangle of the given size whose plane, edges and vertices lie at generic places, its first vertex near the
/// origin.
Mesh large_triangle(double size, double shape = 0.45) {
    const Vec3 a{0.3, -0.2, 0.4};
    const Vec3 along{0.8 * size, 0.36 * size, 0.48 * size};
    const Vec3 across{-0.6 * shape * size, 0.48 * shape * size, 0.64 * shape * size};
    const auto at = [&](double u, double v) {
        return Vec3{a[0] + u * along[0] + v * across[0], a[1] + u * along[1] + v * across[1],
                    a[2] + u * along[2] + v * across[2]};
    };
    return {{at(0, 0), at(1, 0), at(0.4, 1)}, {{0, 1, 2}}, "triangle of " + std::to_string(size) + " voxels"};
}

/// Grids of spacing 1 around vertices, the middles of edges and the middle of a triangle, shifted so that a sample lies
/// `away` from that place.
void check_around_sites(const Mesh& mesh, double away, double half_width) {
    const auto& v = mesh.vertices();
    const auto mix = [&](double a, double b, double c) {
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = a * v[0][axis] + b * v[1][axis] + c * v[2][axis] + away / std::numbers::sqrt3;
        return point;
    };
    for (const Vec3& centre : {mix(1, 0, 0), mix(0, 1, 0), mix(0, 0, 1), mix(0.5, 0.5, 0), mix(0, 0.5, 0.5),
                               mix(0.5, 0, 0.5), mix(0.3, 0.3, 0.4), mix(0.05, 0.9, 0.05)})
        check_exact(mesh, grid_at(centre, 1, 6), Band::symmetric(half_width));
}

}  // namespace

// A sample a thousandth of a voxel from a triangle 500 voxels wide, and all around.
BOOST_AUTO_TEST_CASE(a_large_triangle_is_exact_close_by) {
    for (const double shape : {0.45, 0.05, 0.8}) check_around_sites(large_triangle(500, shape), 1e-3, 3);
}

BOOST_AUTO_TEST_CASE(rounding_does_not_grow_with_the_triangle) {
    for (const double size : {1e4, 1e5, 1e6}) check_around_sites(large_triangle(size), 1e-3, 3);
}

BOOST_AUTO_TEST_CASE(needles_longer_than_the_grid_are_exact) {
    for (const double shape : {1e-3, 1e-6, 1e-9}) check_around_sites(large_triangle(1000, shape), 0.3, 3);
}

// Both sides of a plate are far closer to each other than samples are; no sign may be lost between them.
BOOST_AUTO_TEST_CASE(thin_plates_are_exact) {
    for (const double thickness : {1e-4, 1e-6})
        for (const double angle : {0.0, 0.6, 2.1}) {
            const Mesh mesh = tilted(plate(thickness), angle);
            const Band band = Band::symmetric(0.1);
            check_exact(mesh, Grid::around(mesh, 48, band), band);
        }
}

// Samples inside the plate: the spacing is a third of its thickness along z.
BOOST_AUTO_TEST_CASE(samples_inside_a_thin_plate_are_exact) {
    for (const double thickness : {1e-4, 1e-6}) {
        const Mesh mesh = plate(thickness);
        check_exact(mesh, grid_at({0.03, 0.02, 0.1 * thickness}, thickness / 3, 9), Band::symmetric(thickness));
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_far_from_the_origin_of_its_coordinates_is_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = mesh.box().longest_side() / 24;
    for (const double voxels : {1e6, 1e9}) {
        const Mesh far = shifted(mesh, {voxels * h, -0.7 * voxels * h, 0.3 * voxels * h});
        check_exact(far, grid_around(far, 30, 3), Band::symmetric(3 * h));
    }
}

// The lattice's sample (0, 0, 0) far from the mesh: no number of the device may be as large as an index.
BOOST_AUTO_TEST_CASE(a_mesh_far_from_the_origin_of_the_lattice_is_exact) {
    const Mesh mesh = make_shape("knot");
    const double h = std::exp2(std::round(std::log2(mesh.box().longest_side() / 24)));
    for (const std::int64_t away : {std::int64_t{1} << 20, std::int64_t{1000000000}}) {
        Grid grid = grid_at({0, 0, 0}, h, 15);
        grid.first = {away, -away, away / 2};
        for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] -= h * static_cast<double>(grid.first[axis]);
        check_exact(mesh, grid, Band::symmetric(3 * h));
        grid.spacing = {1.1 * h, 0.9 * h, h};
        grid.origin = {0, 0, 0};
        const Vec3 middle{1.1 * h * static_cast<double>(away + 15), 0.9 * h * static_cast<double>(-away + 15),
                          h * static_cast<double>(away / 2 + 15)};
        check_exact(shifted(mesh, middle), grid, Band::symmetric(3 * h));
    }
}

BOOST_AUTO_TEST_CASE(unequal_spacing_is_exact) {
    const Mesh mesh = tilted(make_shape("torus"));
    const double side = mesh.box().longest_side();
    for (const Vec3 ratio : {Vec3{1, 1, 100}, Vec3{1, 100, 1}, Vec3{100, 1, 1}, Vec3{1, 2.5, 7}, Vec3{1, 1.01, 0.99}}) {
        GridOptions options;
        const double longest = *std::max_element(ratio.begin(), ratio.end());
        const double h = longest > 50 ? side / 300 : side / 60;
        options.spacing = {h * ratio[0], h * ratio[1], h * ratio[2]};
        options.margin = Length::in_mesh_units(3 * h);
        Grid grid = Grid::around(mesh.box(), options);
        // A part of the grid: with dense samples the whole would have too many.
        Index3 first{}, size = grid.size;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            size[axis] = std::min<std::int64_t>(grid.size[axis], 48);
            first[axis] = (grid.size[axis] - size[axis]) / 4;
        }
        grid = grid.part(first, size);
        check_exact(mesh, grid, Band::symmetric(6 * h));
        check_exact(mesh, grid, Band::full());
    }
}

BOOST_AUTO_TEST_CASE(the_scale_of_the_coordinates_does_not_matter) {
    const Mesh mesh = make_shape("knot");
    for (const double factor : {1e-20, 1e-8, 1e8, 1e20}) {
        const Mesh same = scaled(mesh, factor);
        const Band band = Band::symmetric(0.1 * same.box().longest_side());
        check_exact(same, Grid::around(same, 28, band), band);
    }
}

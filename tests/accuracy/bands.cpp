#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Spacing 1 / 8 around a cube whose faces lie on samples.
const Mesh& on_samples() {
    static const Mesh mesh = cube(1);
    return mesh;
}
const Grid& dyadic() {
    static const Grid grid = grid_at({0, 0, 0}, 0.125, 14);
    return grid;
}

const Mesh& between_samples() {
    static const Mesh mesh = tilted(make_shape("knot"));
    return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_band_of_any_widths_is_complete_and_nothing_leaks) {
    const Grid grid = grid_around(between_samples(), 40, 6);
    const double h = grid.voxel();
    for (const double inside : {0.0, 0.3 * h, 2.5 * h, infinite})
        for (const double outside : {0.0, 0.7 * h, 4.2 * h, 1000 * h, infinite}) {
            const Band band = inside + outside > 0 ? Band{inside, outside} : Band::signs_only();
            check_exact(between_samples(), compute(between_samples(), grid, band));
        }
}

BOOST_AUTO_TEST_CASE(an_unsigned_field_uses_the_outside_width_alone) {
    const Grid grid = grid_around(between_samples(), 40, 6);
    const double h = grid.voxel();
    for (const Band band : {Band{0, 3 * h}, Band{5 * h, 2 * h}, Band{infinite, 1.5 * h}})
        check_exact(between_samples(), compute(between_samples(), grid, band, SignRule::none));
}

// Distances to the planes of these faces are exact in floats; on the edges they are within the accuracy, and so may be
// beyond a band without width.
BOOST_AUTO_TEST_CASE(signs_alone_are_minus_zero_inside_and_plus_zero_outside) {
    const Field field = compute(on_samples(), dyadic(), Band::signs_only());
    for (std::int64_t k = 0; k < 29; ++k)
        for (std::int64_t j = 0; j < 29; ++j)
            for (std::int64_t i = 0; i < 29; ++i) {
                std::array<std::int64_t, 3> away{std::abs(i - 14), std::abs(j - 14), std::abs(k - 14)};
                std::sort(away.begin(), away.end());
                const bool on_edge = away[2] == 8 && away[1] == 8;
                const std::size_t at = dyadic().offset(i, j, k);
                BOOST_REQUIRE(field.distance()[at] == 0.0F);
                if (on_edge) continue;
                BOOST_REQUIRE(std::signbit(field.distance()[at]) == (away[2] < 8));
                BOOST_REQUIRE((field.triangle()[at] != no_triangle) == (away[2] == 8));
            }
}

BOOST_AUTO_TEST_CASE(an_inside_without_width_is_filled_with_minus_zero) {
    const Mesh mesh = tilted(cube(1));
    const Field field = compute(mesh, dyadic(), {0, 0.5});
    check_exact(mesh, field);
    const float centre = field.distance()[dyadic().offset(14, 14, 14)];
    BOOST_TEST(centre == 0.0F);
    BOOST_TEST(std::signbit(centre));
}

BOOST_AUTO_TEST_CASE(an_outside_without_width_is_filled_with_plus_zero) {
    const Mesh mesh = tilted(cube(1));
    const Field field = compute(mesh, dyadic(), {0.5, 0});
    check_exact(mesh, field);
    const float corner = field.distance()[dyadic().offset(0, 0, 0)];
    BOOST_TEST(corner == 0.0F);
    BOOST_TEST(!std::signbit(corner));
}

BOOST_AUTO_TEST_CASE(a_distance_equal_to_the_half_width_is_in_the_band) {
    // Three samples from the faces: exact in floats, and a triangle is named.
    const Field field = compute(on_samples(), dyadic(), Band::symmetric(0.375));
    const auto at = [&](std::int64_t i) { return dyadic().offset(i, 14, 14); };
    BOOST_TEST(field.distance()[at(14 + 8 + 3)] == 0.375F);
    BOOST_TEST(field.triangle()[at(14 + 8 + 3)] != no_triangle);
    BOOST_TEST(field.triangle()[at(14 + 8 + 4)] == no_triangle);
    BOOST_TEST(field.distance()[at(14 + 8 - 3)] == -0.375F);
    BOOST_TEST(field.triangle()[at(14 + 8 - 3)] != no_triangle);
    BOOST_TEST(field.triangle()[at(14 + 8 - 4)] == no_triangle);
}

BOOST_AUTO_TEST_CASE(a_band_that_holds_no_sample_leaves_the_sign) {
    // The surface lies in the middle between samples, the band is a tenth of a voxel.
    const Mesh mesh = cube(1.0625);
    const Field field = compute(mesh, dyadic(), Band::symmetric(0.0125));
    BOOST_TEST(check_exact(mesh, field).band_samples == 0U);
}

BOOST_AUTO_TEST_CASE(a_band_larger_than_the_grid_is_the_full_field) {
    const Mesh mesh = make_shape("tetrahedron");
    const Grid grid = grid_around(mesh, 24, 3);
    const Field full = compute(mesh, grid, Band::full());
    const Field wide = compute(mesh, grid, Band::symmetric(1e6));
    check_exact(mesh, full);
    check_exact(mesh, wide);
}

BOOST_AUTO_TEST_CASE(a_half_width_that_makes_no_sense_is_refused) {
    const Mesh mesh = cube(1);
    for (const Band band : {Band{-1, 1}, Band{1, -1}, Band{std::nan(""), 1}, Band{1, std::nan("")}})
        check_throws(ErrorCode::invalid_argument, {}, [&] { compute(mesh, dyadic(), band); });
    check_throws(ErrorCode::invalid_argument, {"1e15", "infinite"},
                 [&] { compute(mesh, dyadic(), Band::symmetric(1e16)); });
    // A zeroed band is one that was forgotten.
    for (const Band& band : {Band{0, 0}, Band{-0.0, 0}, Band::symmetric(0)})
        check_throws(ErrorCode::invalid_argument,
                     {"band", "both half widths are 0", "a band of three voxels", "signs alone"},
                     [&] { compute(mesh, dyadic(), band); });
    check_throws(ErrorCode::invalid_argument, {"1e-60", "range of floats"},
                 [&] { compute(mesh, dyadic(), Band::symmetric(1e-60)); });
    check_throws(ErrorCode::invalid_argument, {"signs alone", "no sign"}, [&] {
        DistanceTransform(test_device(), mesh, {.sign = SignRule::none}).compute(dyadic(), Band::signs_only());
    });
    check_throws(ErrorCode::invalid_argument, {"band", "signs only", "0.5"}, [&] {
        compute(mesh, dyadic(), Band{0.5, 0, true});
    });
}

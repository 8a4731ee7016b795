#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

using namespace clsdf;
using namespace clsdf::test;
using reference::Oracle;
using reference::reference_field;

namespace {

constexpr float positive_zero = 0.0F;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Its faces are on planes of the unit lattice.
Mesh cube() {
    return box({0, 0, 0}, {4, 4, 4}, "cube");
}

/// Samples at the integers -3 ... 7 along x through the cube's middle.
Grid line() {
    return {{-3, 2, 2}, {1, 1, 1}, {11, 1, 1}, {}};
}

std::vector<float> distances_of(const Field& field) {
    return {field.distance().begin(), field.distance().end()};
}

std::vector<float> along_line(const Band& band, SignRule sign = SignRule::nonzero) {
    return distances_of(reference_field(cube(), line(), band, sign));
}

void expect(const std::vector<float>& found, const std::vector<float>& expected) {
    BOOST_TEST(found == expected, boost::test_tools::per_element());
    for (std::size_t i = 0; i < std::min(found.size(), expected.size()); ++i) {
        BOOST_TEST_CONTEXT("sample " << i) {
            BOOST_TEST(std::signbit(found[i]) == std::signbit(expected[i]));
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_full_field_carries_every_distance_and_zero_is_positive) {
    expect(along_line({infinity, infinity}), {3, 2, 1, positive_zero, -1, -2, -1, positive_zero, 1, 2, 3});
}

BOOST_AUTO_TEST_CASE(the_limits_belong_to_the_band_and_beyond_them_is_the_fill_value) {
    expect(along_line({1, 2}), {2, 2, 1, 0, -1, -1, -1, 0, 1, 2, 2});
    expect(along_line({1.5, 1.5}), {1.5F, 1.5F, 1, 0, -1, -1.5F, -1, 0, 1, 1.5F, 1.5F});
    expect(along_line({infinity, 0.5}), {0.5F, 0.5F, 0.5F, 0, -1, -2, -1, 0, 0.5F, 0.5F, 0.5F});
}

BOOST_AUTO_TEST_CASE(a_triangle_is_named_in_the_band_and_at_its_limits_only) {
    const Field field = reference_field(cube(), line(), {1, 2}, SignRule::nonzero);
    const std::span<const std::uint32_t> triangles = field.triangle();
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        // At -3 and 7 the distance is 3, in the middle it is 2 inside.
        const bool in_band = i != 0 && i != 5 && i != 10;
        BOOST_TEST_CONTEXT("sample " << i) {
            BOOST_TEST((triangles[i] != no_triangle) == in_band);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_shell_within_a_shell_is_inside_by_winding_and_outside_by_parity) {
    const Mesh outer = cube();
    std::vector<Vec3> vertices = outer.vertices();
    std::vector<Triangle> triangles = outer.triangles();
    for (const Vec3& v : outer.vertices()) {
        vertices.push_back({1 + v[0] / 2, 1 + v[1] / 2, 1 + v[2] / 2});
    }
    for (const Triangle& t : outer.triangles()) {
        triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    }
    const Mesh nested(vertices, triangles);
    const Grid grid{{-0.5, 2, 2}, {1, 1, 1}, {6, 1, 1}, {}};
    expect(distances_of(reference_field(nested, grid, Band::full(), SignRule::nonzero)),
           {0.5F, -0.5F, -0.5F, -0.5F, -0.5F, 0.5F});
    expect(distances_of(reference_field(nested, grid, Band::full(), SignRule::parity)),
           {0.5F, -0.5F, 0.5F, 0.5F, -0.5F, 0.5F});
}

BOOST_AUTO_TEST_CASE(a_width_of_zero_fills_the_inside_with_negative_zero) {
    expect(along_line({0, 2}), {2, 2, 1, 0, -0.0F, -0.0F, -0.0F, 0, 1, 2, 2});
    expect(along_line({1, 0}), {0, 0, 0, 0, -1, -1, -1, 0, 0, 0, 0});
    expect(along_line(Band::signs_only()), {0, 0, 0, 0, -0.0F, -0.0F, -0.0F, 0, 0, 0, 0});
}

BOOST_AUTO_TEST_CASE(an_unsigned_field_uses_the_outside_width_alone) {
    expect(along_line({7, 1}, SignRule::none), {1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1});
}

BOOST_AUTO_TEST_CASE(a_part_of_the_lattice_has_the_values_of_the_whole) {
    Grid part = line();
    part.first = {2, 0, 0};
    part.size = {4, 1, 1};
    expect(distances_of(reference_field(cube(), part, {1, 2}, SignRule::nonzero)), {1, 0, -1, -1});
}

BOOST_AUTO_TEST_CASE(every_sample_is_what_brute_force_and_the_winding_number_say) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = random_closed(random, 3);
            const Grid grid{{-2, -2, -2}, {0.3, 0.25, 0.4}, {14, 15, 11}, {}};
            const Band band{0.2, 0.5};
            const Field field = reference_field(mesh, grid, band);
            BOOST_TEST((field.sign == SignRule::nonzero));
            const Oracle oracle(mesh);
            for (std::int64_t k = 0; k < grid.size[2]; ++k) {
                for (std::int64_t j = 0; j < grid.size[1]; ++j) {
                    for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                        const Vec3 position = grid.position(i, j, k);
                        const auto nearest = reference::nearest_by_brute_force(mesh, position);
                        const bool inside = oracle.winding_number(position).value() != 0;
                        const double width = inside ? band.inside : band.outside;
                        const bool in_band = nearest.distance <= width;
                        const double magnitude = in_band ? nearest.distance : width;
                        const float expected = static_cast<float>(inside ? -magnitude : magnitude);
                        BOOST_TEST(field.distance()[grid.offset(i, j, k)] == expected,
                                   boost::test_tools::tolerance(1e-6F));
                        if (in_band) {
                            const Triangle& t = mesh.triangles()[field.triangle()[grid.offset(i, j, k)]];
                            const auto named = reference::nearest_on_triangle(
                                position, mesh.vertices()[t[0]], mesh.vertices()[t[1]], mesh.vertices()[t[2]]);
                            BOOST_TEST(named.distance == nearest.distance, boost::test_tools::tolerance(1e-12));
                        } else {
                            BOOST_TEST(field.triangle()[grid.offset(i, j, k)] == no_triangle);
                        }
                    }
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(far_from_the_origin_positions_are_formed_beyond_double_precision) {
    // At 1e9 voxels a position rounded to double is off by up to 1e-7 voxel.
    const double far = 1e9;
    const double spacing = 1.0 + 0x1p-40;
    const Mesh plate({{far, -9, -9}, {far, 9, -9}, {far, 0, 9}}, {{0, 1, 2}});
    const Grid grid{{0, 0, 0}, {spacing, 1, 1}, {3, 1, 1}, {static_cast<std::int64_t>(far) - 3, 0, 0}};
    const Field field = reference_field(plate, grid, {0, 5}, SignRule::none);
    for (std::int64_t i = 0; i < 3; ++i) {
        const long double steps = static_cast<long double>(grid.first[0] + i);
        const long double exact = std::fabs(steps * static_cast<long double>(spacing) - static_cast<long double>(far));
        BOOST_TEST(field.distance()[static_cast<std::size_t>(i)] == static_cast<float>(exact));
    }
}

#include "support/throws.hpp"

#include <clsdf/error.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <limits>
#include <random>

using clsdf::Band;
using clsdf::Box;
using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Grid;
using clsdf::GridOptions;
using clsdf::Index3;
using clsdf::Length;
using clsdf::Vec3;
using clsdf::test::check_throws;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

const Box four_by_two_by_one{{0, 0, 0}, {4, 2, 1}};

bool is_invalid_argument(const Error& error) {
    return error.code() == ErrorCode::invalid_argument;
}

Grid around(const Box& box, std::int64_t resolution, const Length& margin) {
    GridOptions options;
    options.resolution = resolution;
    options.margin = margin;
    return Grid::around(box, options);
}

Grid around_with_spacing(const Box& box, const Vec3& spacing, const Length& margin) {
    GridOptions options;
    options.spacing = spacing;
    options.margin = margin;
    return Grid::around(box, options);
}

Vec3 last_position(const Grid& grid) {
    return grid.position(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
}

void check_centred_and_covering(const Grid& grid, const Box& box, double margin) {
    const Vec3 lower = grid.position(0, 0, 0);
    const Vec3 upper = last_position(grid);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        BOOST_TEST_CONTEXT("axis " << axis) {
            const double slack = 2e-6 * grid.spacing[axis];
            BOOST_TEST(lower[axis] <= box.lower[axis] - margin + slack);
            BOOST_TEST(upper[axis] >= box.upper[axis] + margin - slack);
            BOOST_TEST(std::abs((box.lower[axis] - lower[axis]) - (upper[axis] - box.upper[axis])) <= slack);
            BOOST_TEST(upper[axis] - lower[axis] < box.upper[axis] - box.lower[axis] + 2 * margin + grid.spacing[axis]);
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_grid_around_a_box)

BOOST_AUTO_TEST_CASE(puts_the_resolution_on_the_longest_side_and_covers_the_others) {
    const Grid grid = around(four_by_two_by_one, 9, Length::in_mesh_units(0));
    BOOST_TEST(grid.spacing == (Vec3{0.5, 0.5, 0.5}), boost::test_tools::per_element());
    BOOST_TEST(grid.size == (Index3{9, 5, 3}), boost::test_tools::per_element());
    BOOST_TEST(grid.origin == (Vec3{0, 0, 0}), boost::test_tools::per_element());
    BOOST_TEST(last_position(grid) == (Vec3{4, 2, 1}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(enlarged_by_a_margin_has_that_spacing_to_the_letter) {
    const Grid grid = around(four_by_two_by_one, 100, Length::of_extent(0.1));
    BOOST_TEST(grid.spacing[0] == (4 + 2 * 0.4) / 99);
    BOOST_TEST(grid.size[0] == 100);
    check_centred_and_covering(grid, four_by_two_by_one, 0.4);
}

BOOST_AUTO_TEST_CASE(with_a_margin_in_voxels_keeps_so_many_on_every_side) {
    const Grid grid = around(four_by_two_by_one, 15, Length::in_voxels(3));
    BOOST_TEST(grid.spacing[0] == 4.0 / (15 - 1 - 2 * 3));
    BOOST_TEST(grid.size == (Index3{15, 11, 9}), boost::test_tools::per_element());
    BOOST_TEST(grid.origin == (Vec3{-1.5, -1.5, -1.5}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(is_refused_where_the_margin_in_voxels_leaves_no_room) {
    for (const double voxels : {3.0, 4.0})
        check_throws(ErrorCode::invalid_argument, {fmt::format("margin of {} voxels", voxels), "7 samples"},
                     [&] { around(four_by_two_by_one, 7, Length::in_voxels(voxels)); });
    BOOST_TEST(around(four_by_two_by_one, 8, Length::in_voxels(3)).spacing[0] == 4.0);
}

BOOST_AUTO_TEST_CASE(gains_no_sample_by_rounding_where_a_side_is_a_whole_number_of_voxels) {
    constexpr unsigned seed = 7;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> corner(-1000, 1000);
    std::uniform_real_distribution<double> exponent(-3, 2);
    std::uniform_int_distribution<std::int64_t> count(1, 500);
    for (int round = 0; round < 1000; ++round) {
        BOOST_TEST_CONTEXT("seed " << seed << ", round " << round) {
            const Index3 steps{500, count(random), count(random)};
            const double step = std::pow(10, exponent(random));
            Box box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.lower[axis] = corner(random);
                box.upper[axis] = box.lower[axis] + static_cast<double>(steps[axis]) * step;
            }
            const Index3 expected{steps[0] + 1, steps[1] + 1, steps[2] + 1};
            const auto none = Length::in_voxels(0);
            BOOST_TEST(around(box, 501, none).size == expected, boost::test_tools::per_element());
            const Grid spaced = around_with_spacing(box, {step, step, step}, none);
            BOOST_TEST(spaced.size == expected, boost::test_tools::per_element());
            check_centred_and_covering(spaced, box, 0);
        }
    }
}

BOOST_AUTO_TEST_CASE(covers_any_box_and_stays_centred) {
    constexpr unsigned seed = 11;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> corner(-10, 10);
    std::uniform_real_distribution<double> side(0, 5);
    for (int round = 0; round < 1000; ++round) {
        BOOST_TEST_CONTEXT("seed " << seed << ", round " << round) {
            Box box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.lower[axis] = corner(random);
                box.upper[axis] = box.lower[axis] + side(random);
            }
            const double margin = side(random);
            check_centred_and_covering(around(box, 64, Length::in_mesh_units(margin)), box, margin);
            check_centred_and_covering(around_with_spacing(box, {0.1, 0.2, 1}, Length::in_mesh_units(margin)), box,
                                       margin);
        }
    }
}

BOOST_AUTO_TEST_CASE(that_is_cubic_has_the_resolution_on_every_axis_and_the_box_in_its_centre) {
    GridOptions options;
    options.resolution = 9;
    options.margin = Length::in_mesh_units(0);
    options.cubic = true;
    const Grid grid = Grid::around(four_by_two_by_one, options);
    BOOST_TEST(grid.size == (Index3{9, 9, 9}), boost::test_tools::per_element());
    BOOST_TEST(grid.origin == (Vec3{0, -1, -1.5}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(that_is_cell_centred_lies_half_a_voxel_further) {
    GridOptions options;
    options.spacing = Vec3{1, 0.5, 0.25};
    options.margin = Length::in_mesh_units(0);
    options.cell_centred = true;
    const Grid grid = Grid::around(four_by_two_by_one, options);
    BOOST_TEST(grid.origin == (Vec3{0.5, 0.25, 0.125}), boost::test_tools::per_element());
    BOOST_TEST(grid.size == (Index3{5, 5, 5}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(becomes_cell_centred_by_a_shift_of_every_sample) {
    const Grid nodes{{1, -2, 3}, {1, 0.5, 0.25}, {4, 3, 2}, {-3, 4, 5}};
    const Grid centres = nodes.cell_centred();
    BOOST_TEST(centres.size == nodes.size, boost::test_tools::per_element());
    BOOST_TEST(centres.first == nodes.first, boost::test_tools::per_element());
    for (std::int64_t i = 0; i < 4; ++i)
        for (std::int64_t j = 0; j < 3; ++j)
            for (std::int64_t k = 0; k < 2; ++k) {
                const Vec3 node = nodes.position(i, j, k), shifted{node[0] + 0.5, node[1] + 0.25, node[2] + 0.125};
                BOOST_TEST(centres.position(i, j, k) == shifted, boost::test_tools::per_element());
            }
}

BOOST_AUTO_TEST_CASE(counts_a_margin_in_voxels_by_the_smallest_spacing) {
    const Grid grid = around_with_spacing(four_by_two_by_one, {1, 1, 0.5}, Length::in_voxels(2));
    BOOST_TEST(grid.size == (Index3{7, 5, 7}), boost::test_tools::per_element());
    BOOST_TEST(grid.origin == (Vec3{-1, -1, -1}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(without_extent_needs_a_spacing) {
    const Box point{{1, 2, 3}, {1, 2, 3}};
    BOOST_CHECK_EXCEPTION(around(point, 10, Length::of_extent(0.1)), Error, [](const Error& error) {
        return is_invalid_argument(error) && std::string(error.what()).find("spacing") != std::string::npos;
    });
    BOOST_CHECK_EXCEPTION(around(point, 10, Length::in_voxels(1)), Error, is_invalid_argument);
    const Grid grid = around_with_spacing(point, {1, 1, 1}, Length::in_voxels(1));
    BOOST_TEST(grid.size == (Index3{3, 3, 3}), boost::test_tools::per_element());
    BOOST_TEST(grid.position(1, 1, 1) == (Vec3{1, 2, 3}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(of_a_flat_mesh_and_no_margin_is_one_sample_thick) {
    const Grid grid = around({{0, 0, 5}, {1, 1, 5}}, 11, Length::in_mesh_units(0));
    BOOST_TEST(grid.size == (Index3{11, 11, 1}), boost::test_tools::per_element());
    BOOST_TEST(grid.position(0, 0, 0)[2] == 5.0);
}

BOOST_AUTO_TEST_CASE(that_cannot_be_is_refused) {
    const Length none = Length::in_mesh_units(0);
    BOOST_CHECK_EXCEPTION(around(four_by_two_by_one, 1, none), Error, is_invalid_argument);
    BOOST_CHECK_EXCEPTION(around(four_by_two_by_one, -5, none), Error, is_invalid_argument);
    for (const double value : {-1.0, infinity, not_a_number}) {
        BOOST_TEST_CONTEXT("value " << value) {
            BOOST_CHECK_EXCEPTION(around(four_by_two_by_one, 9, Length::in_mesh_units(value)), Error,
                                  is_invalid_argument);
            check_throws(ErrorCode::invalid_argument, {fmt::format("spacing {}", value)}, [&] {
                around_with_spacing(four_by_two_by_one, {1, value, 1}, none);
            });
            BOOST_CHECK_EXCEPTION(around({{0, 0, 0}, {1, value, 1}}, 9, none), Error, is_invalid_argument);
        }
    }
    BOOST_CHECK_EXCEPTION(around({{-1.5e308, 0, 0}, {1.5e308, 1, 1}}, 9, none), Error, is_invalid_argument);
    BOOST_CHECK_EXCEPTION(around_with_spacing(four_by_two_by_one, {1e-300, 1, 1}, none), Error, is_invalid_argument);
}

BOOST_AUTO_TEST_CASE(around_a_mesh_leaves_room_for_the_outside_of_the_band) {
    const clsdf::Mesh triangle({{0, 0, 0}, {4, 0, 0}, {0, 2, 1}}, {{0, 1, 2}});
    BOOST_TEST(Grid::around(triangle, 51, Band{7, 0.5}).spacing[0] == 5.0 / 50);
    BOOST_TEST(Grid::around(triangle, 45, Band::full()).spacing[0] == (4 + 2 * 0.2) / 44);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(blocks_of_a_lattice)

BOOST_AUTO_TEST_CASE(a_grown_block_has_samples_more_on_every_side) {
    const Grid grid = Grid{{1, 2, 3}, {0.5, 0.25, 1}, {4, 5, 6}, {-2, 0, 7}}.grown(2);
    BOOST_TEST(grid.first == (Index3{-4, -2, 5}), boost::test_tools::per_element());
    BOOST_TEST(grid.size == (Index3{8, 9, 10}), boost::test_tools::per_element());
    BOOST_CHECK(grid.grown(-2).grown(2) == grid);
    BOOST_CHECK_EXCEPTION(grid.grown(-4), Error, is_invalid_argument);
}

BOOST_AUTO_TEST_CASE(a_refined_block_has_all_samples_of_the_coarse_one) {
    const Grid coarse{{1, 2, 3}, {0.5, 0.25, 1}, {4, 5, 1}, {-2, 0, 7}};
    const Grid fine = coarse.refined(4);
    BOOST_TEST(fine.size == (Index3{13, 17, 1}), boost::test_tools::per_element());
    for (std::int64_t i = 0; i < 4; ++i)
        BOOST_TEST(fine.position(4 * i, 4, 0) == coarse.position(i, 1, 0), boost::test_tools::per_element());
    BOOST_CHECK_EXCEPTION(coarse.refined(0), Error, is_invalid_argument);
}

BOOST_AUTO_TEST_CASE(refined_cells_fill_the_coarse_ones) {
    const Grid coarse{{1, 2, 3}, {0.5, 0.25, 1}, {4, 5, 1}, {-2, 0, 7}};
    const Grid fine = coarse.refined_cells(2);
    BOOST_TEST(fine.size == (Index3{8, 10, 2}), boost::test_tools::per_element());
    // The two parts of a cell lie a quarter of it on both sides of its centre.
    for (std::int64_t i = 0; i < 4; ++i) {
        BOOST_TEST(fine.position(2 * i, 0, 0)[0] == coarse.position(i, 0, 0)[0] - 0.125);
        BOOST_TEST(fine.position(2 * i + 1, 1, 1)[0] == coarse.position(i, 0, 0)[0] + 0.125);
    }
    BOOST_CHECK_EXCEPTION(coarse.refined_cells(-1), Error, is_invalid_argument);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(a_part_of_a_grid)

BOOST_AUTO_TEST_CASE(has_its_samples_at_the_same_positions_bit_by_bit) {
    const Grid grid = around({{0.1, 0.2, 0.3}, {1.7, 2.9, 0.7}}, 77, Length::of_extent(0.1));
    const Grid part = grid.part({3, 5, 7}, {10, 11, 12}).part({1, 1, 1}, {2, 3, 4});
    BOOST_TEST(part.first == (Index3{4, 6, 8}), boost::test_tools::per_element());
    BOOST_TEST(part.position(1, 2, 3) == grid.position(5, 8, 11), boost::test_tools::per_element());
    BOOST_TEST(part.sample_count() == 24U);
}

BOOST_AUTO_TEST_CASE(must_lie_inside_the_whole) {
    constexpr std::int64_t huge = std::numeric_limits<std::int64_t>::max();
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 5, 6}, {}};
    BOOST_CHECK(grid.part({0, 0, 0}, {4, 5, 6}) == grid);
    for (const auto& [offset, size] : {std::pair{Index3{-1, 0, 0}, Index3{1, 1, 1}},
                                       {{0, 0, 0}, {5, 1, 1}},
                                       {{0, 5, 0}, {1, 1, 1}},
                                       {{0, 0, 3}, {1, 1, 4}},
                                       {{0, 0, 0}, {1, 0, 1}},
                                       {{huge, 0, 0}, {1, 1, 1}},
                                       {{1, 0, 0}, {huge, 1, 1}}})
        BOOST_CHECK_EXCEPTION(grid.part(offset, size), Error, is_invalid_argument);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(a_grid)

BOOST_AUTO_TEST_CASE(has_samples_where_the_real_number_rounds_to_once) {
    // 3 x 0.1 rounds up before 0.3 is taken off in two steps; formed in one, the rest of the product remains.
    const Grid grid{{-0.3, 0, 0}, {0.1, 1, 1}, {4, 1, 1}, {}};
    BOOST_TEST(grid.position(3, 0, 0)[0] == std::fma(3.0, 0.1, -0.3));
    BOOST_TEST(grid.position(3, 0, 0)[0] != 3.0 * 0.1 - 0.3);
}

BOOST_AUTO_TEST_CASE(counts_more_samples_than_32_bits_and_refuses_more_than_the_address_space) {
    Grid grid{{0, 0, 0}, {1, 1, 1}, {100000, 100000, 3}, {}};
    BOOST_TEST(grid.sample_count() == 30000000000U);
    BOOST_TEST(grid.offset(1, 2, 2) == 20000200001U);
    grid.size = {3000000, 3000000, 3000000};
    BOOST_CHECK_EXCEPTION(grid.sample_count(), Error,
                          [](const Error& error) { return error.code() == ErrorCode::out_of_memory; });
}

BOOST_AUTO_TEST_CASE(is_valid_with_positive_sizes_and_spacings_and_finite_positions) {
    const Grid valid{{-1, 2, 1e9}, {1, 0.5, 1e-9}, {1, 2, 3}, {-5, 0, 5}};
    BOOST_CHECK_NO_THROW(valid.validate());
    const auto refused = [&](auto change) {
        Grid grid = valid;
        change(grid);
        BOOST_CHECK_EXCEPTION(grid.validate(), Error, is_invalid_argument);
    };
    refused([](Grid& grid) { grid.size[1] = 0; });
    refused([](Grid& grid) { grid.size[2] = -3; });
    refused([](Grid& grid) { grid.spacing[0] = 0; });
    refused([](Grid& grid) { grid.spacing[0] = -1; });
    refused([](Grid& grid) { grid.spacing[1] = not_a_number; });
    refused([](Grid& grid) { grid.spacing[2] = infinity; });
    refused([](Grid& grid) { grid.origin[0] = not_a_number; });
    refused([](Grid& grid) { grid.spacing[1] = 1.7e308, grid.size[1] = 3; });
    refused([](Grid& grid) { grid.first[0] = std::numeric_limits<std::int64_t>::max(); });
    refused([](Grid& grid) { grid.size[0] = std::numeric_limits<std::int64_t>::max(); });
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(a_grid_from_corner_to_corner)

BOOST_AUTO_TEST_CASE(begins_at_the_lower_corner_and_rounds_its_spacing_once) {
    constexpr unsigned seed = 3;
    BOOST_TEST_INFO("seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> any(-1, 1), exponent(-30, 30);
    std::uniform_int_distribution<std::int64_t> number(1, 5000);
    std::size_t rounded_twice = 0;
    for (int n = 0; n < 20000; ++n) {
        Vec3 lower{}, upper{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = any(random) * std::exp2(exponent(random));
            upper[axis] = any(random) * std::exp2(exponent(random));
            if (upper[axis] < lower[axis]) std::swap(lower[axis], upper[axis]);
        }
        const Index3 cells{number(random), number(random), number(random)};
        const Grid nodes = Grid::between(lower, upper, {.cells = cells});
        BOOST_REQUIRE(nodes == Grid::between(lower, upper, {.samples = {cells[0] + 1, cells[1] + 1, cells[2] + 1}}));
        BOOST_REQUIRE((nodes.origin == lower && nodes.first == Index3{}));
        const Vec3 last = last_position(nodes);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            BOOST_REQUIRE(nodes.size[axis] == cells[axis] + 1);
            const double step = nodes.spacing[axis], ulp = std::nextafter(step, infinity) - step;
            const auto count = static_cast<double>(cells[axis]);
            const long double side = static_cast<long double>(upper[axis]) - static_cast<long double>(lower[axis]);
            const long double error = std::abs(side / static_cast<long double>(count) - static_cast<long double>(step));
            BOOST_REQUIRE(error <= static_cast<long double>(0.502 * ulp));
            rounded_twice += (upper[axis] - lower[axis]) / count != step ? 1U : 0U;
            const double rounding = std::nextafter(std::abs(upper[axis]), infinity) - std::abs(upper[axis]);
            BOOST_REQUIRE(std::abs(last[axis] - upper[axis]) <= count / 2 * ulp + rounding);
        }
        BOOST_REQUIRE(Grid::between(lower, upper, {.cells = cells, .cell_centred = true}).size == cells);
        BOOST_REQUIRE(Grid::between(lower, upper, {.cells = cells, .cell_centred = true}).origin ==
                      nodes.cell_centred().origin);
    }
    BOOST_TEST(rounded_twice > 100U);  // the test tells the difference
}

BOOST_AUTO_TEST_CASE(takes_one_number_for_all_axes) {
    const Grid grid = Grid::between({-1, -1, -1}, {1, 1, 1}, {.cells = 64});
    BOOST_TEST((grid.size == Index3{65, 65, 65} && grid.spacing == Vec3{0.03125, 0.03125, 0.03125}));
    BOOST_TEST((last_position(grid) == Vec3{1, 1, 1}));
    BOOST_TEST((Grid::between({0, 0, 0}, {1, 2, 3}, {.samples = 2}).spacing == Vec3{1, 2, 3}));
}

BOOST_AUTO_TEST_CASE(is_a_slice_where_the_box_has_no_extent) {
    const Grid slice = Grid::between({-1, 0, 0.1}, {1, 1, 0.1}, {.samples = {41, 41, 1}});
    BOOST_TEST((slice.size == Index3{41, 41, 1} && slice.origin == Vec3{-1, 0, 0.1}));
    BOOST_TEST((slice.spacing == Vec3{0.05, 0.025, 0.025}));
    BOOST_TEST(slice.voxel() == 0.025);
    BOOST_TEST((slice.box().upper == Vec3{1, 1, 0.1}));
    const Grid centres = Grid::between({-1, 0, 0.1}, {1, 1, 0.1}, {.cells = {40, 40, 1}, .cell_centred = true});
    BOOST_TEST((centres.size == Index3{40, 40, 1} && centres.origin == Vec3{-0.975, 0.0125, 0.1}));
    const Grid row = Grid::between({0, 2, 3}, {1, 2, 3}, {.samples = {5, 1, 1}});
    BOOST_TEST((row.size == Index3{5, 1, 1} && row.spacing == Vec3{0.25, 0.25, 0.25} && row.origin == Vec3{0, 2, 3}));
    const auto refuses = [](const Vec3& upper, const clsdf::GridDivision& division, const std::string& word) {
        check_throws(ErrorCode::invalid_argument, {word}, [&] { Grid::between({0, 0, 0}, upper, division); });
    };
    refuses({1, 1, 0}, {.samples = 41}, "give 1 sample along z");
    refuses({1, 1, 0}, {.cells = {40, 40, 1}}, "1 cell with samples at the centres");
    refuses({1, 1, 0}, {.cells = {40, 40, 2}, .cell_centred = true}, "along z");
    refuses({0, 0, 0}, {.samples = 1}, "the box is a point");
}

BOOST_AUTO_TEST_CASE(needs_a_box_and_one_number) {
    const auto refuses = [](const Vec3& upper, const clsdf::GridDivision& division,
                            const std::vector<std::string>& words) {
        check_throws(ErrorCode::invalid_argument, words, [&] { Grid::between({0, 0, 0}, upper, division); });
    };
    refuses({1, 1, 1}, {}, {"samples", "cells", "give one"});
    refuses({1, 1, 1}, {.samples = 3, .cells = 2}, {"give one"});
    refuses({1, 1, 1}, {.samples = 3, .cell_centred = true}, {"centres", "number of cells"});
    refuses({1, 1, 1}, {.samples = {3, 1, 3}}, {"1 sample along y", "from 0 to 1", "same coordinate", "at least 2"});
    refuses({1, 1, 1}, {.samples = {3, 0, 3}}, {"0 samples along y", "at least 2"});
    refuses({1, 1, 1}, {.cells = {3, 3, 0}}, {"0 cells along z", "at least 1"});
    refuses({1, 1, 1}, {.cells = std::int64_t{1} << 60}, {"at most 2^53"});
    refuses({1, 0, 1}, {.cells = 4}, {"from 0 to 0 along y"});
    refuses({1, 1, -1}, {.cells = 4}, {"from 0 to -1 along z"});
    refuses({not_a_number, 1, 1}, {.cells = 4}, {"along x"});
    refuses({infinity, 1, 1}, {.cells = 4}, {"along x", "finite"});
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_CASE(without_a_margin_the_longest_side_begins_at_the_lower_corner) {
    for (const Length margin : {Length::in_mesh_units(0), Length::in_voxels(0), Length::of_extent(0)})
        for (const std::int64_t resolution : {7, 11, 16, 32, 100}) {
            const Box box{{0.1, 0.7, 1e-3}, {1.1, 0.9, 1.001}};
            const Grid grid = around(box, resolution, margin);
            BOOST_TEST(grid.origin[0] == 0.1);
            BOOST_TEST((grid.box().lower[1] + grid.box().upper[1]) / 2 == 0.8, boost::test_tools::tolerance(1e-12));
            const double rounding = static_cast<double>(resolution) * 1e-16;
            BOOST_TEST(std::abs(last_position(grid)[0] - 1.1) <= rounding);
        }
    // All sides of a cube are its longest.
    for (const std::int64_t resolution : {11, 16, 32})
        BOOST_TEST((around({{0, 0, 0}, {1, 1, 1}}, resolution, Length::in_mesh_units(0)).origin == Vec3{}));
}

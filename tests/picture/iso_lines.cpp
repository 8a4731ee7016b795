#include "picture/plane.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

using clsdf::picture::iso_lines;
using clsdf::picture::Plane;
using clsdf::picture::PlanePoint;
using clsdf::picture::Polyline;

namespace {

Plane plane_with(std::int64_t columns, std::int64_t rows, const std::function<double(double, double)>& value) {
    Plane plane;
    plane.size = {columns, rows};
    plane.upper = {1, 1};
    for (std::int64_t row = 0; row < rows; ++row)
        for (std::int64_t column = 0; column < columns; ++column)
            plane.values.push_back(value(static_cast<double>(column), static_cast<double>(row)));
    return plane;
}

Plane random_plane(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-1, 1);
    return plane_with(17, 13, [&](double, double) { return value(random); });
}

std::size_t crossed_edges(const Plane& plane, double level) {
    std::size_t count = 0;
    for (std::int64_t row = 0; row < plane.size[1]; ++row)
        for (std::int64_t column = 0; column < plane.size[0]; ++column) {
            const bool above = plane.sample(column, row) >= level;
            if (column + 1 < plane.size[0]) count += above != (plane.sample(column + 1, row) >= level);
            if (row + 1 < plane.size[1]) count += above != (plane.sample(column, row + 1) >= level);
        }
    return count;
}

bool is_closed(const Polyline& line) {
    return line.size() > 2 && line.front() == line.back();
}

bool on_border(const Plane& plane, const PlanePoint& point) {
    return point[0] == 0 || point[1] == 0 || point[0] == static_cast<double>(plane.size[0] - 1) ||
           point[1] == static_cast<double>(plane.size[1] - 1);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(iso_line)

BOOST_AUTO_TEST_CASE(lies_where_the_field_has_its_value) {
    for (unsigned seed = 0; seed < 20; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            const Plane plane = random_plane(seed);
            double worst = 0;
            for (const Polyline& line : iso_lines(plane, 0.1))
                for (const auto& [column, row] : line) worst = std::max(worst, std::abs(plane.at(column, row) - 0.1));
            BOOST_TEST(worst < 1e-12);
        }
}

BOOST_AUTO_TEST_CASE(crosses_every_edge_between_above_and_below_once) {
    for (unsigned seed = 0; seed < 20; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            const Plane plane = random_plane(seed);
            std::size_t points = 0;
            for (const Polyline& line : iso_lines(plane, 0.1)) points += line.size() - (is_closed(line) ? 1 : 0);
            BOOST_TEST(points == crossed_edges(plane, 0.1));
        }
}

BOOST_AUTO_TEST_CASE(is_closed_or_ends_at_the_border_and_stays_in_one_square_from_point_to_point) {
    for (unsigned seed = 0; seed < 20; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            const Plane plane = random_plane(seed);
            for (const Polyline& line : iso_lines(plane, 0.1)) {
                BOOST_REQUIRE(line.size() > 1);
                BOOST_TEST((is_closed(line) || (on_border(plane, line.front()) && on_border(plane, line.back()))));
                for (std::size_t i = 1; i < line.size(); ++i)
                    for (std::size_t axis = 0; axis < 2; ++axis) {
                        const double low = std::min(line[i - 1][axis], line[i][axis]);
                        const double high = std::max(line[i - 1][axis], line[i][axis]);
                        BOOST_TEST(high <= std::floor(low) + 1);
                    }
            }
        }
}

BOOST_AUTO_TEST_CASE(of_a_circles_distance_is_one_closed_line_around_it) {
    const Plane plane = plane_with(41, 41, [](double x, double y) { return std::hypot(x - 20.3, y - 19.6) - 12; });
    const std::vector<Polyline> lines = iso_lines(plane, 2);
    BOOST_REQUIRE(lines.size() == 1);
    BOOST_TEST(is_closed(lines.front()));
    for (const auto& [x, y] : lines.front()) BOOST_TEST(std::abs(std::hypot(x - 20.3, y - 19.6) - 14) < 1.0 / (8 * 13));
}

BOOST_AUTO_TEST_CASE(splits_a_square_as_its_bilinear_interpolant_is_split) {
    const Plane plane = plane_with(2, 2, [](double x, double y) { return x == y ? 1.0 : 0.0; });
    for (const double level : {0.4, 0.6}) {
        const std::vector<Polyline> lines = iso_lines(plane, level);
        BOOST_REQUIRE(lines.size() == 2);
        for (const Polyline& line : lines) {
            BOOST_REQUIRE(line.size() == 2);
            // The interpolant's hyperbola bends to the square's centre, so the straight line's middle is on the side
            // of the corner that it cuts off: not the centre's.
            const double middle = plane.at((line[0][0] + line[1][0]) / 2, (line[0][1] + line[1][1]) / 2);
            BOOST_TEST((middle > level) != (0.5 > level));
        }
    }
}

BOOST_AUTO_TEST_CASE(keeps_away_from_what_is_not_a_number) {
    Plane plane = plane_with(6, 3, [](double, double y) { return y - 0.5; });
    plane.values[3] = std::nan("");
    plane.values[0] = -std::numeric_limits<double>::infinity();
    const std::vector<Polyline> lines = iso_lines(plane, 0);
    BOOST_REQUIRE(lines.size() == 2);
    for (const Polyline& line : lines)
        for (const auto& [column, row] : line) {
            BOOST_TEST(row == 0.5);
            BOOST_TEST(((column >= 1 && column <= 2) || column >= 4));
        }
}

BOOST_AUTO_TEST_SUITE_END()

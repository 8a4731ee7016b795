#include "picture/plane.hpp"

#include "picture/example.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

using clsdf::ErrorCode;
using clsdf::Field;
using clsdf::Output;
using clsdf::picture::axes_beside;
using clsdf::picture::Axis;
using clsdf::picture::Plane;
using clsdf::picture::plane_of;
using clsdf::test::check_throws;
using clsdf::test::two_balls;

BOOST_AUTO_TEST_SUITE(plane_of_a_slice)

BOOST_AUTO_TEST_CASE(has_the_samples_of_the_field_on_each_axis) {
    const Field field = two_balls(true, 10);
    const Plane x = plane_of(field, {Axis::x, 7}, {Axis::z, Axis::y});
    BOOST_TEST(x.size[0] == 21);
    BOOST_TEST(x.size[1] == 31);
    BOOST_TEST(x.sample(3, 5) == static_cast<double>(field.distance()[field.grid.offset(7, 5, 3)]));
    BOOST_TEST(x.lower[0] == -0.8);
    BOOST_TEST(x.upper[1] == 0.9, boost::test_tools::tolerance(1e-12));
    const Plane y = plane_of(field, {Axis::y, 7}, axes_beside(Axis::y));
    BOOST_TEST(y.sample(3, 5) == static_cast<double>(field.distance()[field.grid.offset(3, 7, 5)]));
    const Plane z = plane_of(field, {Axis::z, 7}, axes_beside(Axis::z));
    BOOST_TEST(z.sample(3, 5) == static_cast<double>(field.distance()[field.grid.offset(3, 5, 7)]));
}

BOOST_AUTO_TEST_CASE(has_between_equal_samples_exactly_their_value) {
    Plane plane;
    plane.size = {2, 2};
    for (const double value : {static_cast<double>(0.1F), 0.1, -1.0 / 3}) {
        plane.values.assign(4, value);
        for (int i = 0; i <= 1000; ++i) BOOST_TEST(plane.at(i / 1000.0, 1 - i / 999.0) == value);
    }
}

BOOST_AUTO_TEST_CASE(keeps_the_band_as_it_is_and_what_is_beyond_it_beyond) {
    const Field field = two_balls(true, 0.2);
    const auto limit = static_cast<double>(0.2F);
    const Plane plane = plane_of(field, {Axis::z, 10}, axes_beside(Axis::z));
    int continued = 0;
    for (std::int64_t row = 0; row < plane.size[1]; ++row)
        for (std::int64_t column = 0; column < plane.size[0]; ++column) {
            const auto given = static_cast<double>(field.distance()[field.grid.offset(column, row, 10)]);
            const double drawn = plane.sample(column, row);
            if (std::abs(given) < limit) BOOST_TEST(drawn == given);
            if (given == limit) BOOST_TEST(drawn >= limit);
            if (given == -limit) BOOST_TEST(drawn <= -limit);
            continued += std::abs(drawn) > 1.001 * limit;
        }
    BOOST_TEST(continued > 20);
}

BOOST_AUTO_TEST_CASE(ends_where_the_band_does) {
    const Field narrow = two_balls(true, 0.2);
    const Field wide = two_balls(true, 10);
    const Plane drawn = plane_of(narrow, {Axis::z, 10}, axes_beside(Axis::z));
    const Plane whole = plane_of(wide, {Axis::z, 10}, axes_beside(Axis::z));
    // Wherever a point's true distance is clear of the limit by a quarter of a voxel, it is drawn on the right side.
    for (int j = 0; j < 130; ++j)
        for (int i = 0; i < 217; ++i) {
            const double row = 0.23 * j;
            const double column = 0.23 * i;
            const double distance = whole.at(column, row);
            if (distance > 0 && std::abs(distance - 0.2) > 0.0125)
                BOOST_TEST((drawn.at(column, row) >= static_cast<double>(0.2F)) == (distance > 0.2),
                           "at column " << column << ", row " << row << ": " << distance);
        }
}

BOOST_AUTO_TEST_CASE(knows_the_inside_of_a_band_without_inside) {
    Field field = two_balls(true, 10);
    field.band = {0, 10};
    for (float& distance : field.distance())
        if (std::signbit(distance)) distance = -0.0F;
    const Plane plane = plane_of(field, {Axis::z, 10}, axes_beside(Axis::z));
    BOOST_TEST(plane.sample(16, 15) < 0);  // the middle of a ball
}

BOOST_AUTO_TEST_CASE(is_refused_where_the_field_has_none) {
    Field field = two_balls();
    check_throws(ErrorCode::invalid_argument, {"no sample 21 along z", "0 to 20"}, [&] {
        plane_of(field, {Axis::z, 21}, axes_beside(Axis::z));
    });
    check_throws(ErrorCode::invalid_argument, {"no sample -1 along x", "0 to 50"}, [&] {
        plane_of(field, {Axis::x, -1}, axes_beside(Axis::x));
    });
    field.grid.size = {51, 31, 1};
    field.resize(Output::distance, field.grid.sample_count());
    check_throws(ErrorCode::invalid_argument, {"single sample along z", "perpendicular to x"}, [&] {
        plane_of(field, {Axis::x, 0}, axes_beside(Axis::x));
    });
    plane_of(field, {Axis::z, 0}, axes_beside(Axis::z));
    check_throws(ErrorCode::invalid_argument, {"\"w\"", "x, y or z"}, [] { clsdf::picture::parse_axis("w"); });
}

BOOST_AUTO_TEST_SUITE_END()

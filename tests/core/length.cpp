#include "support/throws.hpp"

#include <clsdf/error.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/version.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

using clsdf::Band;
using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Length;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

bool is_invalid_argument(const Error& error) {
    return error.code() == ErrorCode::invalid_argument;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_length_is_in_percent_of_the_longest_side_in_voxels_or_in_mesh_units) {
    constexpr double voxel = 0.5;
    constexpr double extent = 20;
    BOOST_TEST(Length::of_extent(0.1).resolve(voxel, extent) == 2.0);
    BOOST_TEST(Length::in_voxels(3).resolve(voxel, extent) == 1.5);
    BOOST_TEST(Length::in_mesh_units(0.05).resolve(voxel, extent) == 0.05);
    BOOST_TEST(Length::infinite().is_infinite());
    BOOST_TEST(Length::infinite().resolve(0, 0) == infinity);
    BOOST_TEST(Length::in_voxels(infinity).resolve(0, 0) == infinity);
}

BOOST_AUTO_TEST_CASE(a_length_is_read_from_a_text) {
    constexpr double voxel = 0.5;
    constexpr double extent = 20;
    const auto length = [](const char* text) { return Length::parse(text, "--band"); };
    BOOST_TEST(length("10%").resolve(voxel, extent) == 2.0);
    BOOST_TEST(length("3v").resolve(voxel, extent) == 1.5);
    BOOST_TEST(length("0.05").resolve(voxel, extent) == 0.05);
    BOOST_TEST(length("1e-3").resolve(voxel, extent) == 1e-3);
    BOOST_TEST(length("0").resolve(voxel, extent) == 0.0);
    BOOST_TEST(length("full").is_infinite());
}

BOOST_AUTO_TEST_CASE(a_text_that_is_no_length_is_quoted) {
    for (const std::string text :
         {"", "%", "v", "-1", "+1", "3 v", " 3", "3x", "3vv", "nan", "inf", "1e999", "Full", "0x10"})
        BOOST_TEST_CONTEXT("length \"" << text << "\"")
    clsdf::test::check_throws(ErrorCode::invalid_argument, {"--band: ", '"' + text + '"'},
                              [&] { Length::parse(text, "--band"); });
}

BOOST_AUTO_TEST_SUITE(a_band)

BOOST_AUTO_TEST_CASE(has_half_widths_from_zero_to_infinity) {
    BOOST_CHECK_NO_THROW(Band::signs_only().validate());
    BOOST_CHECK_EXCEPTION((Band{0, 0}.validate()), Error, is_invalid_argument);
    BOOST_CHECK_NO_THROW((Band{0, infinity}.validate()));
    BOOST_CHECK_NO_THROW(Band::full().validate());
    for (const double width : {-1.0, -infinity, not_a_number}) {
        BOOST_CHECK_EXCEPTION((Band{width, 1}.validate()), Error, is_invalid_argument);
        BOOST_CHECK_EXCEPTION((Band{1, width}.validate()), Error, is_invalid_argument);
    }
}

BOOST_AUTO_TEST_CASE(that_nobody_has_set_is_refused) {
    for (const Band& band : {Band{}, Band{.inside = 1}, Band{.outside = 1}})
        BOOST_CHECK_EXCEPTION(band.validate(), Error, [](const Error& error) {
            return is_invalid_argument(error) && std::string(error.what()).find("not set") != std::string::npos &&
                   std::string(error.what()).find("use the full band") != std::string::npos;
        });
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_CASE(the_version_has_three_numbers) {
    const std::string version = clsdf::version();
    BOOST_TEST(std::count(version.begin(), version.end(), '.') == 2);
}

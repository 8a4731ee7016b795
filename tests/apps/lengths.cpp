#include "option_values.hpp"

#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <string>

using clsdf::ErrorCode;

BOOST_AUTO_TEST_SUITE(a_length_on_the_command_line)

BOOST_AUTO_TEST_CASE(is_in_percent_of_the_longest_side_in_voxels_or_in_mesh_units) {
    constexpr double voxel = 0.5;
    constexpr double extent = 20;
    BOOST_TEST(parse_length("--band", "10%").resolve(voxel, extent) == 2.0);
    BOOST_TEST(parse_length("--band", "3v").resolve(voxel, extent) == 1.5);
    BOOST_TEST(parse_length("--band", "0.05").resolve(voxel, extent) == 0.05);
    BOOST_TEST(parse_length("--band", "1e-3").resolve(voxel, extent) == 1e-3);
    BOOST_TEST(parse_length("--band", "0").resolve(voxel, extent) == 0.0);
    BOOST_TEST(parse_length("--band", "full").is_infinite());
}

BOOST_AUTO_TEST_CASE(that_cannot_be_read_is_quoted) {
    for (const std::string text : {"", "%", "v", "-1", "3 v", " 3", "3x", "3vv", "nan", "inf", "1e999", "Full", "0x10"})
        BOOST_TEST_CONTEXT("length \"" << text << "\"")
    clsdf::test::check_throws(ErrorCode::invalid_argument, {"--band", '"' + text + '"'},
                              [&] { parse_length("--band", text); });
}

BOOST_AUTO_TEST_SUITE_END()

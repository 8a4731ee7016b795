#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const std::vector<float> six_values{0, 1, -2, 3.5F, -0.25F, 1e-30F};

std::string six_bytes(std::endian order = std::endian::little) {
    return bytes_of(six_values, order);
}

const std::string fields =
    "NRRD0004\n"
    "type: float\n"
    "dimension: 3\n"
    "sizes: 3 2 1\n"
    "endian: little\n"
    "encoding: raw\n";
const std::string place =
    "space dimension: 3\n"
    "space directions: (0.5,0,0) (0,1,0) (0,0,2)\n"
    "space origin: (-1, 2, 3e2)\n";

}  // namespace

BOOST_AUTO_TEST_SUITE(an_nrrd_file_of_another_program)

BOOST_AUTO_TEST_CASE(is_read_with_a_band_without_end_and_an_unknown_sign_rule) {
    const TemporaryFolder folder;
    const Field field = read_field(folder.file("a.nrrd", fields + place + "\n" + six_bytes()));
    BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
    BOOST_TEST(field.grid.origin == (Vec3{-1, 2, 300}), boost::test_tools::per_element());
    BOOST_TEST(field.grid.spacing == (Vec3{0.5, 1, 2}), boost::test_tools::per_element());
    BOOST_TEST(field.grid.size == (Index3{3, 2, 1}), boost::test_tools::per_element());
    BOOST_TEST(field.band.outside == std::numeric_limits<double>::infinity());
    BOOST_CHECK(field.sign == clsdf::SignRule::automatic);
}

BOOST_AUTO_TEST_CASE(is_read_in_either_byte_order_as_float_or_double_with_any_line_ends_and_case) {
    const TemporaryFolder folder;
    const std::string big = replaced(fields, "little", "Big") + place + "\n" + six_bytes(std::endian::big);
    BOOST_TEST(read_field(folder.file("big.nrrd", big)).distance() == six_values, boost::test_tools::per_element());

    const std::vector<double> doubles(six_values.begin(), six_values.end());
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        std::string header = replaced(fields, "float", "double") + place + "\n";
        if (order == std::endian::big) header = replaced(header, "little", "big");
        const Field field = read_field(folder.file("double.nrrd", header + bytes_of(doubles, order)));
        BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
    }

    std::string dos;
    for (const char letter : "# a comment\nContent: x: y\n" + fields.substr(9) + place + "\n")
        if (letter != '\0') dos += letter == '\n' ? std::string("\r\n") : std::string(1, letter);
    BOOST_TEST(read_field(folder.file("dos.nrrd", "NRRD0004\r\n" + dos + six_bytes())).distance() == six_values,
               boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(may_state_spacings_and_axis_minimums_of_nodes_or_cells) {
    const TemporaryFolder folder;
    const std::string spaced = fields + "spacings: 0.5 1 2\naxis mins: 1 2 3\n";
    const Field nodes = read_field(folder.file("n.nrrd", spaced + "centers: node node node\n\n" + six_bytes()));
    BOOST_TEST(nodes.grid.origin == (Vec3{1, 2, 3}), boost::test_tools::per_element());
    const Field cells = read_field(folder.file("c.nrrd", spaced + "centerings: cell cell cell\n\n" + six_bytes()));
    BOOST_TEST(cells.grid.origin == (Vec3{1.25, 2.5, 4}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(that_was_cropped_from_ours_has_the_place_it_states_and_not_the_old_lattice) {
    const TemporaryFolder folder;
    const std::string old_lattice = "clsdf_lattice_origin:=7 7 7\nclsdf_lattice_first:=1 1 1\n";
    const Field field = read_field(folder.file("a.nrrd", fields + place + old_lattice + "\n" + six_bytes()));
    BOOST_TEST(field.grid.position(0, 0, 0) == (Vec3{-1, 2, 300}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(that_names_a_file_that_no_system_can_have_is_read_without_it) {
    const TemporaryFolder folder;
    const std::string other = "clsdf_triangle_file:=" + std::string(300, 'x') + "\n";
    const std::string path = folder.file("a.nrrd", fields + place + other + "\n" + six_bytes());
    BOOST_TEST(read_field(path).triangle().empty());
    BOOST_TEST(missing_field_files(path).size() == 1U);
}

BOOST_AUTO_TEST_CASE(that_does_not_say_enough_is_refused_with_the_field_the_value_and_the_remedy) {
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& header, const std::vector<std::string>& fragments) {
        const std::string path = folder.file("refused.nrrd", header + "\n" + six_bytes());
        std::vector<std::string> expected = fragments;
        expected.push_back(path);
        check_throws(ErrorCode::unreadable_input, expected, [&] { read_field(path); });
    };
    const std::string whole = fields + place;
    refused(fields, {"'spacings' is missing"});
    refused(fields + "spacings: 1 1 1\n", {"'axis mins' is missing", "space origin"});
    refused(fields + "spacings: 1 1 1\naxis mins: 0 0 0\n", {"'centers' is missing"});
    refused(replaced(whole, "encoding: raw", "encoding: gzip"), {"encoding", "gzip", "uncompressed"});
    refused(replaced(whole, "type: float", "type: short"), {"type", "short", "float"});
    refused(replaced(whole, "type: float", "type: unsigned int"), {"type", "unsigned int"});
    refused(replaced(whole, "endian: little\n", ""), {"'endian' is missing"});
    refused(replaced(whole, "dimension: 3", "dimension: 4"), {"dimension", "'4'"});
    refused(replaced(whole, "sizes: 3 2 1", "sizes: 3 2"), {"sizes", "'3 2'"});
    refused(replaced(whole, "sizes: 3 2 1", "sizes: 3 -2 -1"), {"sizes", "-2"});
    refused(replaced(whole, "sizes: 3 2 1", "sizes: 3 2 0"), {"sizes", "0"});
    refused(replaced(whole, "sizes: 3 2 1", "sizes: 3 1 1"), {"sizes", "3 x 1 x 1", "12"});
    refused(replaced(whole, "sizes: 3 2 1", "sizes: 4294967296 4294967296 4294967296"), {"sizes", "truncated"});
    refused(replaced(whole, "sizes: 3 2 1", "sizes: 99999999999999999999 1 1"), {"sizes"});
    refused(replaced(whole, "(0.5,0,0)", "(0.5,0.1,0)"), {"space directions", "parallel"});
    const std::string turned = replaced(whole, "(0.5,0,0)", "(0.5,3e-17,0)") + "\n" + six_bytes();
    BOOST_TEST(read_field(folder.file("turned.nrrd", turned)).grid.spacing[0] == 0.5);
    refused(replaced(whole, "(0.5,0,0)", "none"), {"space directions"});
    refused(replaced(whole, "(0.5,0,0)", "(-0.5,0,0)"), {"spacing", "-0.5"});
    refused(replaced(whole, "(0.5,0,0)", "(nan,0,0)"), {"spacing", "nan"});
    refused(replaced(whole, "(-1, 2, 3e2)", "(-1, 2)"), {"space origin", "(-1, 2)"});
    refused(replaced(whole, "(-1, 2, 3e2)", "(-1, 2, inf)"), {"origin", "inf"});
    refused(whole + "data file: a.raw\n", {"data file", "a.raw", "attached"});
    refused(whole + "byte skip: -1\n", {"byte skip", "-1"});
    refused(whole + "type: float\n", {"second time"});
    refused(whole + "nonsense\n", {"nonsense", "line 10"});
    refused(whole + "clsdf_band_inside:=-1\n", {"band", "-1"});
    refused(whole + "clsdf_band_outside:=wide\n", {"clsdf_band_outside", "wide"});
    refused(whole + "clsdf_sign:=sometimes\n", {"sometimes"});
    refused(whole + "clsdf_triangle_file:=../secret\n", {"../secret"});
    refused("P6\n", {"not an NRRD file"});
    // A NUL would end the message before it says what is wrong.
    using namespace std::string_literals;
    refused(whole + "ab\0cd\n"s, {"'ab?cd' is neither"});
    refused(replaced(whole, "type: float", "type: fl\0oat"s), {"'fl?oat': a distance field is of float or double"});
    refused(whole + "clsdf_sign:=some\0times\n"s, {"'some?times' is no sign rule"});
    refused(whole + "clsdf_triangle_file:=../\0secret\n"s, {"'../?secret' is not the name"});
}

BOOST_AUTO_TEST_SUITE_END()

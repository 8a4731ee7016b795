#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const std::vector<float> six_values{0, 1, -2, 3.5F, -0.25F, 1e-30F};
const std::string six_bytes = bytes_of(six_values, std::endian::little);
const std::string dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }\n";
const std::string place = R"({"origin": [1, 2, 3.5], "spacing": [0.5, 1, 2], "size": [3, 2, 1]})";

std::string npy(const std::string& text, int version = 1) {
    std::string result = "\x93NUMPY";
    result += static_cast<char>(version);
    result += '\0';
    for (std::size_t i = 0; i < (version == 1 ? 2U : 4U); ++i) result += static_cast<char>(i == 0 ? text.size() : 0);
    return result + text;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(an_npy_field)

BOOST_AUTO_TEST_CASE(is_what_numpy_expects) {
    const TemporaryFolder folder;
    write_field(example_field(), folder.file("field.npy"));
    const std::string content = content_of(folder.file("field.npy"));
    const std::size_t header = content.size() - 24 * sizeof(float);
    BOOST_TEST(header % 64 == 0U);
    BOOST_TEST(content[header - 1] == '\n');
    BOOST_TEST(content.find("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 4), }") == 10U);
    BOOST_TEST(static_cast<std::size_t>(content[8]) + 256 * static_cast<std::size_t>(content[9]) + 10 == header);
}

BOOST_AUTO_TEST_CASE(has_a_description_beside_it) {
    const TemporaryFolder folder;
    write_field(example_field(), folder.file("field.npy"));
    const auto description = nlohmann::json::parse(content_of(folder.file("field.npy.json")));
    BOOST_TEST(description["size"].get<Index3>() == (Index3{4, 3, 2}), boost::test_tools::per_element());
    BOOST_TEST(description["lattice"]["first"].get<Index3>() == (Index3{2, 10, 12}), boost::test_tools::per_element());
    BOOST_TEST(description["band"]["outside"].is_null());
    BOOST_TEST(description["sign"].get<std::string>() == "nonzero");
    BOOST_TEST(description["triangle"].get<std::string>() == "field_triangle.npy");
}

BOOST_AUTO_TEST_CASE(of_another_program_needs_origin_spacing_and_size) {
    const TemporaryFolder folder;
    folder.file("a.npy.json", place);
    const Field field = read_field(folder.file("a.npy", npy(dictionary) + six_bytes));
    BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
    BOOST_TEST(field.grid.origin == (Vec3{1, 2, 3.5}), boost::test_tools::per_element());
    BOOST_TEST(field.grid.size == (Index3{3, 2, 1}), boost::test_tools::per_element());
    BOOST_CHECK(field.sign == clsdf::SignRule::automatic);
    BOOST_TEST(read_field(folder.file("a.npy", npy(dictionary, 2) + six_bytes)).distance() == six_values,
               boost::test_tools::per_element());

    const std::vector<double> doubles(six_values.begin(), six_values.end());
    const std::string big_double = R"({"shape":(1,2,3),"descr":">f8","fortran_order":False})";
    BOOST_TEST(read_field(folder.file("a.npy", npy(big_double) + bytes_of(doubles, std::endian::big))).distance() ==
                   six_values,
               boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(with_a_header_that_says_something_else_is_refused) {
    const TemporaryFolder folder;
    folder.file("a.npy.json", place);
    const auto refused = [&](const std::string& content, const std::string& fragment) {
        const std::string path = folder.file("a.npy", content);
        check_throws(ErrorCode::unreadable_input, {path, fragment}, [&] { read_field(path); });
    };
    const auto header = [](const std::string& type, const std::string& order, const std::string& shape) {
        return npy("{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }") + six_bytes;
    };
    refused(header("<f4", "True", "(1, 2, 3)"), "ascontiguousarray");
    refused(header("<i4", "False", "(1, 2, 3)"), "'<i4'");
    refused(header("<u4", "False", "(1, 2, 3)"), "'<u4'");
    refused(header("", "False", "(1, 2, 3)"), "descr");
    refused(header("<f4", "False", "(6,)"), "shape");
    refused(header("<f4", "False", "(3, 2, 1)"), "a.npy.json");
    refused(header("<f4", "False", "(1, 2, 2)"), "unused");
    refused(header("<f4", "False", "(1, 2, 4)"), "truncated");
    refused(header("<f4", "False", "(-1, -2, 3)"), "-1");
    refused(header("<f4", "False", "(4294967296, 4294967296, 4294967296)"), "truncated");
    refused(npy("{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (1, 2, 3)}") + six_bytes, "descr");
    refused(npy("{}") + six_bytes, "descr");
    refused(npy(std::string("{\0}", 3)) + six_bytes, "'{?}' does not state");
    refused(header(std::string("<f\0", 3), "False", "(1, 2, 3)"), "'<f?' is not read");
    refused(npy(dictionary, 9) + six_bytes, "version 9");
    refused(npy(dictionary).substr(0, 30), "truncated");
    refused("\x93NUMPY", "truncated");
    refused("", "not an .npy file");
}

BOOST_AUTO_TEST_CASE(with_a_description_that_is_missing_or_wrong_is_refused) {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.npy", npy(dictionary) + six_bytes);
    check_throws(ErrorCode::unreadable_input, {"a.npy.json", "origin"}, [&] { read_field(path); });
    const auto refused = [&](const std::string& description, const std::string& fragment) {
        folder.file("a.npy.json", description);
        check_throws(ErrorCode::unreadable_input, {path, fragment}, [&] { read_field(path); });
    };
    // Half a million brackets would not fit a stack.
    const std::string deep = std::string(400'000, '[') + std::string(400'000, ']');
    for (const char* member : {"size", "mesh", "sign"})
        refused(R"({"size": [3, 2, 1], "origin": [0, 0, 0], "spacing": [1, 1, 1], ")" + std::string(member) + R"(": )" +
                    deep + "}",
                member);
    refused("", "not JSON");
    refused("{\"origin\": [1, 2", "not JSON");
    refused(std::string(100000, '['), "not JSON");
    refused(std::string(2000000, ' '), "2000000");
    refused("[1]", "object");
    refused(R"({"spacing": [0.5, 1, 2], "size": [3, 2, 1]})", "'/origin' is missing");
    refused(R"({"origin": [1, 2], "spacing": [0.5, 1, 2], "size": [3, 2, 1]})", "/origin");
    refused(R"({"origin": [1, 2, "3"], "spacing": [0.5, 1, 2], "size": [3, 2, 1]})", "/origin");
    refused(R"({"origin": [1, 2, 3], "spacing": [0.5, 1, 0], "size": [3, 2, 1]})", "spacing");
    refused(R"({"origin": [1, 2, 3], "spacing": [0.5, 1, 1], "size": [3, 2, 1.5]})", "/size");
    refused(R"({"origin": [1, 2, 3], "spacing": [0.5, 1, 1], "size": [3, 2, -1]})", "-1");
    refused(place.substr(0, place.size() - 1) + R"(, "band": {"inside": -1}})", "-1");
    refused(place.substr(0, place.size() - 1) + R"(, "band": {"inside": "wide"}})", "/band/inside");
    refused(place.substr(0, place.size() - 1) + R"(, "band": "x"})", "member '/band': \"x\": expected an object");
    refused(place.substr(0, place.size() - 1) + R"(, "lattice": 3})", "member '/lattice': 3: expected an object");
    refused(place.substr(0, place.size() - 1) + R"(, "sign": "sometimes"})", "sometimes");
    refused(place.substr(0, place.size() - 1) + R"(, "triangle": "/etc/passwd"})", "/etc/passwd");
}

BOOST_AUTO_TEST_SUITE_END()

#include <boost/test/unit_test.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "kernel_sources.hpp"

using clsdf::kernels::files;

BOOST_AUTO_TEST_CASE(the_table_names_the_files_in_order) {
    BOOST_TEST_REQUIRE(std::size(files) == 2U);
    BOOST_TEST(files[0].name == "treacherous.cl");
    BOOST_TEST(files[1].name == "empty.h");
}

namespace {

boost::test_tools::assertion_result in_its_build(boost::unit_test::test_unit_id) {
    boost::test_tools::assertion_result result(std::filesystem::exists(TREACHEROUS));
    if (!result) result.message() << "it supposes the build's own file " << TREACHEROUS;
    return result;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_text_is_embedded_byte_by_byte, *boost::unit_test::precondition(in_its_build)) {
    std::ifstream file(TREACHEROUS, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    BOOST_TEST(text.size() > 100'000U);
    BOOST_TEST((files[0].text == text));
}

BOOST_AUTO_TEST_CASE(an_empty_file_is_an_empty_text) {
    BOOST_TEST(files[1].text.empty());
}

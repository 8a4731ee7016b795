#include "core/real_numbers.hpp"

#include <boost/test/unit_test.hpp>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

namespace clsdf {

BOOST_AUTO_TEST_SUITE(real_numbers)

BOOST_AUTO_TEST_CASE(are_read_to_the_end_of_the_number) {
    const std::string text = "-1.5e2,7";
    double value = 0;
    const auto [stop, error] = read_real(text.data(), text.data() + text.size(), value);
    BOOST_TEST((error == std::errc()));
    BOOST_TEST(stop - text.data() == 6);
    BOOST_TEST(value == -150);
    for (const std::string wrong : {"", "-", "+1", " 1", ".", "e5", "x"})
        BOOST_TEST((read_real(wrong.data(), wrong.data() + wrong.size(), value).ec == std::errc::invalid_argument));
}

#ifdef __cpp_lib_to_chars
namespace {

template <class Real>
bool agree(const std::string& text) {
    const char* const begin = text.data();
    const char* const end = begin + text.size();
    Real expected = 7, found = 7;
    const auto [expected_stop, expected_error] = std::from_chars(begin, end, expected);
    const auto [stop, error] = detail::read_real_in_c(begin, end, found);
    using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
    return stop == expected_stop && error == expected_error &&
           (std::bit_cast<Bits>(found) == std::bit_cast<Bits>(expected) || (std::isnan(found) && std::isnan(expected)));
}

}  // namespace

BOOST_AUTO_TEST_CASE(have_the_same_grammar_and_bits_without_from_chars_of_the_standard_library) {
    const std::uint32_t seed = std::random_device{}();
    std::mt19937 random(seed);
    const std::vector<std::string> parts{
        "0",    "1",           "9",   "-",     "+", ".",     "e",        "E",   "1234567890123",
        "inf",  "NaN",         "(",   "a_1",   ")", "INITY", "e308",     "e38", "e-45",
        "e-46", "e400",        "e39", "e-324", " ", "x",     "4.9e-324", ",",   "e-99999999999",
        "0x1",  "e99999999999"};
    for (int i = 0; i < 100000; ++i) {
        std::string text;
        for (std::size_t count = 1 + random() % 6; count > 0; --count) text += parts[random() % parts.size()];
        BOOST_TEST_CONTEXT("'" << text << "'; seed " << seed) {
            BOOST_REQUIRE(agree<double>(text));
            BOOST_REQUIRE(agree<float>(text));
        }
    }
}
#endif

BOOST_AUTO_TEST_SUITE_END()

}  // namespace clsdf

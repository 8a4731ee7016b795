#include "picture/text.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <random>
#include <set>

using clsdf::picture::number;
using clsdf::picture::round_step;
using clsdf::picture::round_values;
using clsdf::picture::Scale;
using clsdf::picture::scale_between;

BOOST_AUTO_TEST_SUITE(round_value)

BOOST_AUTO_TEST_CASE(steps_are_one_two_or_five_times_a_power_of_ten) {
    BOOST_TEST(round_step(0.011) == 0.02);
    BOOST_TEST(round_step(0.021) == 0.05);
    BOOST_TEST(round_step(0.051) == 0.1);
    BOOST_TEST(round_step(1) == 1);
    BOOST_TEST(round_step(2.0000000000001) == 2);
    BOOST_TEST(round_step(30) == 50);
}

BOOST_AUTO_TEST_CASE(multiples_of_the_step_include_the_limits_and_an_exact_zero) {
    const std::vector<double> values = round_values(-0.3, 0.2, 0.1);
    BOOST_REQUIRE(values.size() == 6);
    BOOST_TEST(values[3] == 0);
    BOOST_TEST(!std::signbit(values[3]));
    BOOST_TEST(values.front() == -0.3, boost::test_tools::tolerance(1e-12));
    BOOST_TEST(values.back() == 0.2, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(labels_tell_the_values_apart_with_no_digit_to_spare) {
    const Scale scale = scale_between(-0.1, 0.1, 10);
    BOOST_REQUIRE(scale.labels.size() == 11);
    BOOST_TEST(scale.labels.front() == "−0.10");
    BOOST_TEST(scale.labels[5] == "0.00");
    BOOST_TEST(scale.labels.back() == "0.10");
    BOOST_TEST(scale.remark.empty());
}

BOOST_AUTO_TEST_CASE(what_large_and_small_numbers_share_is_said_once) {
    const Scale small = scale_between(0, 3e-7, 3);
    BOOST_TEST(small.labels.back() == "300");
    BOOST_TEST(small.remark == " × 10⁹");
    const Scale large = scale_between(0, 4e8, 4);
    BOOST_TEST(large.labels.back() == "400");
    BOOST_TEST(large.remark == " × 10⁻⁶");
    const Scale far = scale_between(1000000.002, 1000000.006, 4);
    BOOST_TEST(far.labels.front() == "0.002");
    BOOST_TEST(far.remark == " − 1000000.000");
}

BOOST_AUTO_TEST_CASE(labels_differ_wherever_the_limits_are) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> exponent(-12, 12);
    for (int attempt = 0; attempt < 2000; ++attempt) {
        const double lower = std::pow(10, exponent(random)) * (attempt % 2 == 0 ? 1 : -1);
        const double upper = lower + std::pow(10, exponent(random));
        if (upper - lower < 1e-10 * std::abs(lower)) continue;
        BOOST_TEST_CONTEXT("from " << lower << " to " << upper) {
            const Scale scale = scale_between(lower, upper, 8);
            BOOST_TEST(scale.labels.size() <= 9U);
            BOOST_TEST(std::set<std::string>(scale.labels.begin(), scale.labels.end()).size() == scale.labels.size());
            for (const std::string& label : scale.labels) BOOST_TEST(label.size() < 14U);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_negative_number_has_a_minus_sign) {
    BOOST_TEST(number(-0.0123456, 4) == "−0.01235");
    BOOST_TEST(number(-0.0, 4) == "0");
}

BOOST_AUTO_TEST_SUITE_END()

#include "papers/root_sum.hpp"
#include "support/random_meshes.hpp"
#include "support/temporary_folder.hpp"
#include "support/test_meshes.hpp"

#include <clsdf/papers.hpp>

#include <boost/multiprecision/mpfr.hpp>
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <filesystem>

using namespace clsdf;
using namespace clsdf::test;
using papers::RootSum;

namespace {

// Many times the digits that the sums below need to be told from zero.
using Judge =
    boost::multiprecision::number<boost::multiprecision::mpfr_float_backend<3000>, boost::multiprecision::et_off>;

/// The same sum twice.
struct Both {
    RootSum sum;
    Judge judge;

    explicit Both(double value) : sum(value), judge(value) {}
    Both(RootSum s, Judge j) : sum(std::move(s)), judge(std::move(j)) {}

    friend Both operator+(const Both& a, const Both& b) { return {a.sum + b.sum, a.judge + b.judge}; }
    friend Both operator-(const Both& a, const Both& b) { return {a.sum - b.sum, a.judge - b.judge}; }
    friend Both operator*(const Both& a, const Both& b) { return {a.sum * b.sum, a.judge * b.judge}; }
    friend Both operator/(const Both& a, const Both& b) { return {a.sum / b.sum, a.judge / b.judge}; }
};

Both root(double square) {
    return {RootSum::square_root(RootSum(square)), boost::multiprecision::sqrt(Judge(square))};
}

int sign_of(const Judge& judge) {
    // Zero is what is smaller than any sum here that is not zero.
    if (boost::multiprecision::abs(judge) < boost::multiprecision::pow(Judge(10), -2500)) return 0;
    return judge > 0 ? 1 : -1;
}

/// The working folder of whoever calls the library; back to the former one at the end.
class WorkingFolder {
public:
    WorkingFolder() : former_(std::filesystem::current_path()) { std::filesystem::current_path(folder_.file("")); }
    ~WorkingFolder() { std::filesystem::current_path(former_); }
    WorkingFolder(const WorkingFolder&) = delete;
    WorkingFolder& operator=(const WorkingFolder&) = delete;

    std::size_t file_count() const { return folder_.file_count(); }

private:
    TemporaryFolder folder_;
    std::filesystem::path former_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_number_of_any_size_has_its_sign) {
    for (const double value : {0.0, 1.0, 0.1, 1e300, 5e-324, 1.7976931348623157e308}) {
        BOOST_TEST(RootSum(value).sign() == (value > 0 ? 1 : 0));
        BOOST_TEST(RootSum(-value).sign() == (value > 0 ? -1 : 0));
        BOOST_TEST(RootSum::square_root(RootSum(value)).sign() == (value > 0 ? 1 : 0));
        BOOST_TEST((RootSum(value) - RootSum::square_root(RootSum(value) * RootSum(value))).sign() == 0);
    }
}

BOOST_AUTO_TEST_CASE(zero_is_seen_from_the_terms) {
    BOOST_TEST((root(2).sum + root(8).sum - root(18).sum).sign() == 0);
    BOOST_TEST((root(0.5).sum - RootSum(1) / root(2).sum).sign() == 0);
    BOOST_TEST((root(2).sum * root(3).sum - root(6).sum).sign() == 0);
    BOOST_TEST((root(0.75).sum * root(3).sum - RootSum(1.5)).sign() == 0);
    BOOST_TEST(((root(2).sum + root(3).sum) * (root(2).sum - root(3).sum) + RootSum(1)).sign() == 0);
}

// p^2 - 2 q^2 = 1 or -1: the sum is 1 / (p + q sqrt 2), as near to zero as one likes.
BOOST_AUTO_TEST_CASE(a_sum_next_to_zero_has_its_sign) {
    RootSum p(1);
    RootSum q(1);
    const RootSum two_root = root(2).sum;
    for (int step = 0; step < 2000; ++step) {
        const int expected = step % 2 == 0 ? -1 : 1;
        const RootSum difference = p - q * two_root;
        BOOST_REQUIRE(difference.sign() == expected);
        BOOST_REQUIRE((RootSum() - difference).sign() == -expected);
        const RootSum next = p + q + q;
        q = p + q;
        p = next;
    }
}

BOOST_AUTO_TEST_CASE(sums_of_roots_have_the_sign_that_three_thousand_digits_give) {
    std::size_t zeros = 0;
    std::size_t close = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const auto number = [&] {
                return random.index(2) == 0 ? std::round(random.uniform(-9, 9))
                                            : std::ldexp(random.uniform(-1, 1), static_cast<int>(random.index(200)));
            };
            Both sum(0);
            for (std::uint32_t terms = 1 + random.index(5); terms > 0; --terms) {
                const double radicand = random.index(2) == 0 ? 1 + random.index(12) : std::abs(number()) + 0.5;
                Both term = Both(number()) * root(radicand);
                if (random.index(3) == 0) term = term / root(1 + random.index(12));
                if (random.index(3) == 0) term = term * root(1 + random.index(12));
                sum = sum + term;
            }
            BOOST_TEST(sum.sum.sign() == sign_of(sum.judge));
            // Against what it is in double, and squared, so that as many digits cancel twice.
            const Both less = sum - Both(static_cast<double>(sum.judge));
            BOOST_TEST(less.sum.sign() == sign_of(less.judge));
            const Both squared = sum * sum - Both(static_cast<double>(sum.judge)) * sum;
            BOOST_TEST(squared.sum.sign() == sign_of(squared.judge));
            zeros += sign_of(sum.judge) == 0;
            close += sign_of(less.judge) != 0;
        }
    BOOST_TEST(zeros > 5U);
    BOOST_TEST(close > 300U);
}

BOOST_AUTO_TEST_CASE(nothing_appears_in_the_working_folder) {
    const WorkingFolder here;
    RootSum sum;
    for (int i = 1; i < 40; ++i) sum = sum + RootSum(i % 3 - 1) * root(i).sum;
    BOOST_TEST(sum.sign() != 0);
    std::size_t exact_decisions = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        Random random(seed);
        std::vector<Vec3> ring{{1, 0, 0},  {1, 1, 0},   {0, 1, 0},  {-1, 1, 0},
                               {-1, 0, 0}, {-1, -1, 0}, {0, -1, 0}, {1, -1, 0}};
        for (Vec3& neighbour : ring) neighbour[2] = std::round(random.uniform(-1.5, 1.5)) * std::ldexp(1, -40);
        exact_decisions += examine_saddles(closed_fan("lattice", ring)).exact_decisions;
    }
    BOOST_TEST(exact_decisions > 1000U);
    BOOST_TEST(here.file_count() == 0U);
}

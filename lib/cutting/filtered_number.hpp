#pragma once

#include <cmath>
#include <limits>
#include <optional>

// What follows is compiled without contraction (lib/CMakeLists.txt).
namespace clsdf::cutting {

/// A number that is known up to an error: the sum of two doubles, the second at most half an ulp of the first
/// (T. J. Dekker, A floating-point technique for extending the available precision, 1971). Sums and products of few
/// digits have no error at all.
struct FilteredNumber {
    double high = 0, low = 0;
    double error = 0;  ///< a bound; infinite if nothing is known

    FilteredNumber() = default;
    FilteredNumber(double value) : high(value) {}  // NOLINT(google-explicit-constructor): a double is such a number
    FilteredNumber(double given_high, double given_low, double given_error)
        : high(given_high), low(given_low), error(given_error) {}

    static FilteredNumber unknown() { return {0, 0, std::numeric_limits<double>::infinity()}; }

    /// Nothing if the error is too large to tell.
    std::optional<int> sign() const {
        if (std::abs(high) - std::abs(low) > error) return high > 0 ? 1 : -1;
        return high == 0 && error == 0 ? std::optional<int>(0) : std::nullopt;
    }
    FilteredNumber operator-() const { return {-high, -low, error}; }
};

namespace detail {
constexpr double rounding = 0x1p-52;          // twice that of an operation
constexpr double above_errors = 1 + 0x1p-48;  // more than the roundings of a sum of bounds
constexpr double least_exact = 0x1p-900;      // smaller products may lose digits

inline FilteredNumber with_rest(double high, double rest, double error) {
    const double sum = high + rest;
    return {sum, rest - (sum - high), error * above_errors};
}
}  // namespace detail

inline FilteredNumber operator+(const FilteredNumber& a, const FilteredNumber& b) {
    const double sum = a.high + b.high, part = sum - a.high;
    const double rest = (a.high - (sum - part)) + (b.high - part), low = a.low + b.low;
    const double off = low == 0 ? 0 : detail::rounding * (std::abs(a.low) + std::abs(b.low) + std::abs(rest));
    return detail::with_rest(sum, rest + low, a.error + b.error + off);
}

inline FilteredNumber operator-(const FilteredNumber& a, const FilteredNumber& b) {
    return a + -b;
}

inline FilteredNumber operator*(const FilteredNumber& a, const FilteredNumber& b) {
    const double product = a.high * b.high, rest = std::fma(a.high, b.high, -product);
    double error =
        a.error * (std::abs(b.high) + std::abs(b.low) + b.error) + b.error * (std::abs(a.high) + std::abs(a.low));
    double low = 0;
    if (a.low != 0 || b.low != 0) {
        const double left = a.high * b.low, right = a.low * b.high;
        low = left + right;
        error += 2 * detail::rounding * (std::abs(left) + std::abs(right) + std::abs(rest)) + std::abs(a.low * b.low);
    }
    if (std::abs(product) < detail::least_exact && a.high != 0 && b.high != 0) error += detail::least_exact;
    return detail::with_rest(product, rest + low, error);
}

}  // namespace clsdf::cutting

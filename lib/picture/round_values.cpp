#include "picture/round_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::picture {
namespace {

constexpr double rounding = 1e-9;  // of a step: tolerance of the limits

std::string with_minus_signs(std::string text) {
    for (std::size_t at = 0; (at = text.find('-', at)) != std::string::npos;) text.replace(at, 1, "\u2212");
    return text;
}

std::string superscript(int number) {
    static const char* const digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string text;
    for (const char letter : fmt::format("{}", number)) text += letter == '-' ? "⁻" : digits[letter - '0'];
    return text;
}

std::string fixed(double value, int decimals) {
    return with_minus_signs(fmt::format("{:.{}f}", value, decimals));
}

int decimals_of(double step) {
    return std::max(0, static_cast<int>(std::ceil(-std::log10(step) - rounding)));
}

}  // namespace

double round_step(double least) {
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= least * (1 - rounding)) return factor * power;
    return 10 * power;
}

std::vector<double> round_values(double lower, double upper, double step) {
    std::vector<double> values;
    const double last = std::floor(upper / step + rounding);
    // If the limits are so large that a step is less than their rounding, there are no round values between them.
    for (double n = std::ceil(lower / step - rounding); n <= last && values.size() < 1000; ++n)
        values.push_back(n * step + 0.0);  // no -0
    return values;
}

Scale scale_between(double lower, double upper, int count) {
    return scale_with_step(lower, upper, round_step((upper - lower) / count));
}

Scale scale_with_step(double lower, double upper, double step) {
    Scale scale{round_values(lower, upper, step), {}, {}};

    const double largest = std::max(std::abs(lower), std::abs(upper));
    double offset = 0;
    if (largest / step > 1e5) {
        // Digits that all the numbers share.
        offset = std::floor(lower / (100 * step)) * (100 * step);
        scale.remark = fmt::format(" {} {}", offset < 0 ? "+" : "\u2212", fixed(std::abs(offset), decimals_of(step)));
    }
    int exponent = 0;
    const double size = offset == 0 ? largest : 100 * step;
    if (decimals_of(step) > 4 || size >= 1e5) exponent = 3 * static_cast<int>(std::floor(std::log10(size) / 3));
    const double unit = std::pow(10.0, exponent);
    if (exponent != 0)
        scale.remark = (offset == 0 ? "" : " (" + scale.remark.substr(1) + ")") + " × 10" + superscript(-exponent);
    for (const double value : scale.values)
        scale.labels.push_back(fixed((value - offset) / unit + 0.0, decimals_of(step / unit)));
    return scale;
}

std::string number(double value, int digits) {
    return with_minus_signs(fmt::format("{:.{}g}", value + 0.0, digits));
}

}  // namespace clsdf::picture

#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace clsdf::picture {

/// The text with every byte that is not UTF-8 replaced; if it is longer than `characters`, its middle is left out.
std::string printable(const std::string& text, std::size_t characters);

/// The same in ASCII, for fonts without special signs: "−2 × 10⁻⁶" becomes "-2 x 10^-6", and other signs become
/// question marks. The text must be UTF-8.
std::string in_ascii(const std::string& text);

/// The smallest of 1, 2, 5 x 10^n that is not below `least`, which is positive and finite.
double round_step(double least);

/// The multiples of `step` within [lower, upper], ascending; zero is exact.
std::vector<double> round_values(double lower, double upper, double step);

/// Numbers along an axis or a colour bar, with the fewest digits that distinguish them. A common factor and a common
/// offset are stated once: value = label x 10^exponent + offset.
struct Scale {
    std::vector<double> values;
    std::vector<std::string> labels;
    /// "" or " × 10⁻⁶" or " − 1000000": the text after the axis' name that states factor and offset.
    std::string remark;
};

/// The multiples of `step` within [lower, upper], and their labels.
Scale scale_with_step(double lower, double upper, double step);

/// Round values within [lower, upper], at most about `count`, and their labels.
Scale scale_between(double lower, double upper, int count);

/// Any length as text, with so many significant digits and a minus sign that is not a hyphen.
std::string number(double value, int digits);

}  // namespace clsdf::picture

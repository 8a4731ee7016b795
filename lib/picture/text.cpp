#include "picture/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf::picture {

namespace {

// The number of bytes of the first character, or 0 if it is not valid UTF-8.
std::size_t character_length(std::string_view text) {
    const auto byte = [&](std::size_t index) { return static_cast<unsigned char>(text[index]); };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xC2 ? 0
                               : first < 0xE0 ? 2
                               : first < 0xF0 ? 3
                               : first < 0xF5 ? 4
                                              : 0;
    if (length == 0 || length > text.size()) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xC0U) != 0x80) return 0;
    // Overlong forms, surrogates and what lies beyond Unicode.
    if ((first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F) || (first == 0xF0 && byte(1) < 0x90) ||
        (first == 0xF4 && byte(1) > 0x8F))
        return 0;
    return length;
}

}  // namespace

std::string printable(const std::string& text, std::size_t characters) {
    std::vector<std::string> parts;
    for (std::string_view rest = text; !rest.empty();) {
        const std::size_t length = character_length(rest);
        const bool shown = length > 0 && static_cast<unsigned char>(rest[0]) >= 0x20;
        parts.push_back(shown ? std::string(rest.substr(0, length)) : "\uFFFD");
        rest.remove_prefix(length > 0 ? length : 1);
    }
    if (parts.size() > characters) {
        const auto half = static_cast<std::ptrdiff_t>(characters / 2);
        parts.erase(parts.begin() + half, parts.end() - half);
        parts.insert(parts.begin() + half, "…");
    }
    std::string result;
    for (const std::string& part : parts) result += part;
    return result;
}

std::string in_ascii(const std::string& text) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 14> forms{{{"−", "-"},
                                                                                          {"×", "x"},
                                                                                          {"…", "..."},
                                                                                          {"⁻", "-"},
                                                                                          {"⁰", "0"},
                                                                                          {"¹", "1"},
                                                                                          {"²", "2"},
                                                                                          {"³", "3"},
                                                                                          {"⁴", "4"},
                                                                                          {"⁵", "5"},
                                                                                          {"⁶", "6"},
                                                                                          {"⁷", "7"},
                                                                                          {"⁸", "8"},
                                                                                          {"⁹", "9"}}};
    std::string result;
    bool raised = false;
    for (std::string_view rest = text; !rest.empty();) {
        const std::string_view character = rest.substr(0, std::max<std::size_t>(1, character_length(rest)));
        rest.remove_prefix(character.size());
        if (character.size() == 1) {
            result += character;
            raised = false;
            continue;
        }
        const auto* form = std::find_if(forms.begin(), forms.end(),
                                        [&](const auto& candidate) { return candidate.first == character; });
        const bool superscript = form != forms.end() && form - forms.begin() >= 3;
        if (superscript && !raised) result += '^';
        raised = superscript;
        result += form == forms.end() ? "?" : form->second;
    }
    return result;
}

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

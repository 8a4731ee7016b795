#pragma once

#include <charconv>
#include <clocale>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#if __has_include(<xlocale.h>)  // strtod_l of macOS and the BSDs
#include <xlocale.h>
#endif

/// Parsing of floats and doubles. All is in the header, because the command cannot link hidden functions of the
/// library.
namespace clsdf {

namespace detail {

/// The length of the number at the begin of a text, in the grammar of std::from_chars: an optional '-', then digits
/// with an optional point and exponent, or "inf", "infinity", "nan" or "nan(...)" in upper or lower case; 0 if there is
/// none.
inline std::size_t real_length(std::string_view text) {
    const auto is_digit = [&](std::size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; };
    const auto is = [&](std::size_t i, char c) { return i < text.size() && (text[i] | 0x20) == c; };
    const auto has_word = [&](std::size_t begin, std::string_view word) {
        for (std::size_t i = 0; i < word.size(); ++i)
            if (!is(begin + i, word[i])) return false;
        return true;
    };
    const std::size_t begin = text.starts_with('-') ? 1 : 0;
    if (has_word(begin, "infinity")) return begin + 8;
    if (has_word(begin, "inf")) return begin + 3;
    if (has_word(begin, "nan")) {
        std::size_t end = begin + 3;
        if (end == text.size() || text[end] != '(') return end;
        const auto is_of_word = [&](std::size_t i) {
            return is_digit(i) || (i < text.size() && ((text[i] | 0x20) >= 'a' && (text[i] | 0x20) <= 'z')) ||
                   (i < text.size() && text[i] == '_');
        };
        do ++end;
        while (is_of_word(end));
        return end < text.size() && text[end] == ')' ? end + 1 : begin + 3;
    }
    std::size_t end = begin, digits = 0;
    for (; is_digit(end); ++end) ++digits;
    if (end < text.size() && text[end] == '.')
        for (++end; is_digit(end); ++end) ++digits;
    if (digits == 0) return 0;
    if (is(end, 'e')) {
        std::size_t exponent = end + 1;
        if (exponent < text.size() && (text[exponent] == '-' || text[exponent] == '+')) ++exponent;
        if (is_digit(exponent)) {
            end = exponent;
            while (is_digit(end)) ++end;
        }
    }
    return end;
}

/// The same as std::from_chars, by the C library.
template <class Real>
std::from_chars_result read_real_in_c(const char* begin, const char* end, Real& value) {
    static const locale_t classic = newlocale(LC_ALL_MASK, "C", nullptr);
    const std::string text(begin, real_length({begin, static_cast<std::size_t>(end - begin)}));
    if (text.empty()) return {begin, std::errc::invalid_argument};
    const char* const stop = begin + text.size();
    Real read{};
    if constexpr (std::is_same_v<Real, float>)
        read = strtof_l(text.c_str(), nullptr, classic);
    else
        read = strtod_l(text.c_str(), nullptr, classic);
    const std::string_view mantissa = std::string_view(text).substr(0, text.find_first_of("eE"));
    const bool is_finite_text = text.find_first_of("nN") == std::string::npos;  // neither "inf" nor "nan"
    const bool has_digit = mantissa.find_first_of("123456789") != std::string_view::npos;
    if (is_finite_text && (std::isinf(read) || (read == 0 && has_digit))) return {stop, std::errc::result_out_of_range};
    value = read;
    return {stop, std::errc()};
}

}  // namespace detail

/// Reads the number at the begin of [begin, end) as std::from_chars does, in every locale and with every standard
/// library: libc++ before version 20 has from_chars for whole numbers only. A value that is out of range, or too small
/// for a denormal number, is not set.
template <class Real>
std::from_chars_result read_real(const char* begin, const char* end, Real& value) {
    static_assert(std::is_same_v<Real, float> || std::is_same_v<Real, double>);
#ifdef __cpp_lib_to_chars
    return std::from_chars(begin, end, value);
#else
    return detail::read_real_in_c(begin, end, value);
#endif
}

/// The same for whole numbers, for templates of both.
template <class Number>
std::from_chars_result read_number(const char* begin, const char* end, Number& value) {
    if constexpr (std::is_floating_point_v<Number>)
        return read_real(begin, end, value);
    else
        return std::from_chars(begin, end, value);
}

}  // namespace clsdf

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

/// The same as std::from_chars, by the C library, whose functions also accept white space, a '+' and hexadecimal
/// digits.
template <class Real>
std::from_chars_result read_real_in_c(const char* begin, const char* end, Real& value) {
    static const locale_t classic = newlocale(LC_ALL_MASK, "C", nullptr);
    constexpr std::string_view of_numbers =
        "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ+-.()_";  // "nan(...)" has any letters
    std::string_view rest(begin, static_cast<std::size_t>(end - begin));
    rest = rest.substr(0, rest.find_first_not_of(of_numbers));
    const std::size_t zero = rest.starts_with('-') ? 1 : 0;
    if (rest.starts_with('+')) rest = {};
    if (rest.size() > zero + 1 && rest[zero] == '0' && (rest[zero + 1] | 0x20) == 'x') rest = rest.substr(0, zero + 1);
    const std::string text(rest);
    char* stop = nullptr;
    Real read{};
    if constexpr (std::is_same_v<Real, float>)
        read = strtof_l(text.c_str(), &stop, classic);
    else
        read = strtod_l(text.c_str(), &stop, classic);
    const std::string_view number = rest.substr(0, static_cast<std::size_t>(stop - text.c_str()));
    if (number.empty()) return {begin, std::errc::invalid_argument};
    const std::string_view mantissa = number.substr(0, number.find_first_of("eE"));
    const bool is_finite_text = number.find_first_of("nN") == std::string_view::npos;  // neither "inf" nor "nan"
    const bool has_digit = mantissa.find_first_of("123456789") != std::string_view::npos;
    if (is_finite_text && (std::isinf(read) || (read == 0 && has_digit)))
        return {begin + number.size(), std::errc::result_out_of_range};
    value = read;
    return {begin + number.size(), std::errc()};
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

#include "io/meshes/text_scanner.hpp"

#include "core/real_numbers.hpp"
#include "tools/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

namespace clsdf {

namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

bool is_line_end(char c) {
    return c == '\n' || c == '\r';
}

/// read_real() does not set a value that is out of range. Here numbers that are too small round to zero, and numbers
/// that are too large to infinity.
double out_of_range_value(std::string_view word) {
    const bool negative = word.front() == '-';
    if (negative) word.remove_prefix(1);
    const std::string_view mantissa = word.substr(0, word.find_first_of("eE"));
    std::string_view exponent = word.substr(std::min(mantissa.size() + 1, word.size()));
    if (exponent.starts_with('+')) exponent.remove_prefix(1);
    std::int64_t power = 0;
    if (std::from_chars(exponent.data(), exponent.data() + exponent.size(), power).ec == std::errc::result_out_of_range)
        power = exponent.front() == '-' ? std::numeric_limits<std::int64_t>::min() / 2
                                        : std::numeric_limits<std::int64_t>::max() / 2;
    // The power of ten of the first digit that is not zero.
    power += static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size())) -
             static_cast<std::int64_t>(mantissa.find_first_of("123456789"));
    const double magnitude = power < 0 ? 0.0 : std::numeric_limits<double>::infinity();
    return negative ? -magnitude : magnitude;
}

/// A value that is not finite, as older C libraries of Windows write it: "1.#QNAN", "-1.#IND00".
struct WindowsValue {
    double value;
    std::size_t length;  ///< without zeros that follow
};

/// The value with which the text begins; its '#' is at `hash`.
std::optional<WindowsValue> windows_value(std::string_view text, std::size_t hash) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    constexpr std::array<std::pair<std::string_view, double>, 4> names{
        {{"qnan", nan}, {"snan", nan}, {"ind", nan}, {"inf", infinity}}};
    const std::string_view before = text.substr(0, hash), after = text.substr(hash + 1);
    if (before != "1." && before != "-1." && before != "+1.") return {};
    for (const auto& [name, value] : names)
        if (equals_ignoring_case(after.substr(0, name.size()), name))
            return WindowsValue{before[0] == '-' ? -value : value, hash + 1 + name.size()};
    return {};
}

/// Whether the '#' within [begin, end) is that of such a value, and no comment.
bool is_number_of_windows(const char* begin, const char* hash, const char* end) {
    constexpr std::size_t longest = 8;  // "-1.#QNAN"
    if (hash - begin > 3) return false;
    const std::string_view word(begin, std::min(longest, static_cast<std::size_t>(end - begin)));
    return windows_value(word, static_cast<std::size_t>(hash - begin)).has_value();
}

/// The value of a word that std::from_chars does not read to its end, if it is a number as other programs write it:
/// "1.0D+00" and "1.0+120" of Fortran, "1.#QNAN" of Windows.
std::optional<double> foreign_number(std::string_view word) {
    if (const std::size_t hash = word.find('#'); hash != std::string_view::npos) {
        const std::optional<WindowsValue> found = windows_value(word, hash);
        if (!found || word.find_first_not_of('0', found->length) != std::string_view::npos) return {};
        return found->value;
    }
    std::size_t end = word.find_first_of("dDqQ"), exponent = end + 1;
    if (end == std::string_view::npos) {
        // Without a letter before an exponent of three digits; "1-3" without a point is no number.
        end = exponent = std::min(word.find_first_of("+-", 1), word.size());
        if (word.substr(0, end).find('.') == std::string_view::npos) return {};
    }
    const std::string text = fmt::format("{}e{}", word.substr(0, end), word.substr(exponent));
    double value = 0;
    const auto [stop, error] = read_real(text.data(), text.data() + text.size(), value);
    if (error == std::errc::invalid_argument || stop != text.data() + text.size()) return {};
    return error == std::errc::result_out_of_range ? out_of_range_value(text) : value;
}

/// "0,000000e+00": as programs write numbers in the language of a country that has a comma there.
bool is_decimal_comma(std::string_view word) {
    const std::size_t comma = word.find(',');
    if (comma == std::string_view::npos || comma + 1 == word.size()) return false;
    std::string text(word);
    text[comma] = '.';
    const std::string_view digits = std::string_view(text).substr(text[0] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, error] = read_real(digits.data(), digits.data() + digits.size(), value);
    return error != std::errc::invalid_argument && end == digits.data() + digits.size();
}

}  // namespace

TextScanner::TextScanner(std::string_view text, const std::string& path, Syntax syntax, std::size_t first_line)
    : position_(text.data()), end_(text.data() + text.size()), path_(&path), syntax_(syntax), line_(first_line) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (text.starts_with(byte_order_mark)) position_ += byte_order_mark.size();
}

std::size_t TextScanner::line_end_length() const {
    if (position_ == end_ || !is_line_end(*position_)) return 0;
    const auto next_is = [&](std::ptrdiff_t ahead, char c) {
        return end_ - position_ > ahead && position_[ahead] == c;
    };
    if (*position_ == '\r') return next_is(1, '\n') ? 2 : 1;
    // LF CR, unless that CR begins a CR LF.
    return next_is(1, '\r') && !next_is(2, '\n') ? 2 : 1;
}

void TextScanner::skip_line_end() {
    position_ += line_end_length();
    ++line_;
}

void TextScanner::skip_blanks() {
    while (position_ != end_) {
        if (is_blank(*position_)) {
            ++position_;
        } else if (*position_ == '\\' && syntax_.line_continuation) {
            ++position_;
            if (line_end_length() == 0) {
                --position_;
                return;
            }
            skip_line_end();
        } else if (*position_ == '#' && syntax_.hash_comments) {
            while (position_ != end_ && !is_line_end(*position_)) ++position_;
            return;
        } else {
            return;
        }
    }
}

bool TextScanner::at_end_of_line() {
    skip_blanks();
    return position_ == end_ || is_line_end(*position_);
}

bool TextScanner::next_line() {
    if (!before_first_line_)
        while (!at_end_of_line()) word();
    before_first_line_ = false;
    while (at_end_of_line()) {
        if (position_ == end_) return false;
        skip_line_end();
    }
    return true;
}

bool TextScanner::end_line() {
    if (!at_end_of_line() || position_ == end_) return false;
    skip_line_end();
    return true;
}

std::string_view TextScanner::word() {
    if (at_end_of_line()) return {};
    const char* begin = position_;
    const auto ends_word = [&](const char* c) {
        if (is_blank(*c) || is_line_end(*c)) return true;
        if (*c == '#') return syntax_.hash_comments && !is_number_of_windows(begin, c, end_);
        return *c == '\\' && syntax_.line_continuation && c + 1 != end_ && is_line_end(c[1]);
    };
    while (position_ != end_ && !ends_word(position_)) ++position_;
    return {begin, static_cast<std::size_t>(position_ - begin)};
}

void TextScanner::skip(std::size_t letters) {
    skip_blanks();
    position_ += letters;
}

std::string_view TextScanner::word_of_text() {
    before_first_line_ = false;
    while (at_end_of_line()) {
        if (position_ == end_) return {};
        skip_line_end();
    }
    return word();
}

double TextScanner::real(const char* what) {
    return real_in(word(), what);
}

double TextScanner::real_in(std::string_view text, const char* what) const {
    std::string_view digits = text;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = read_real(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) {
        if (const std::optional<double> foreign = foreign_number(digits)) return *foreign;
        fail_word(what, text);
    }
    return error == std::errc::result_out_of_range ? out_of_range_value(digits) : value;
}

std::int64_t TextScanner::integer(const char* what) {
    const std::string_view text = word();
    std::string_view digits = text;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) fail_word(what, text);
    return value;
}

void TextScanner::first_line() {
    if (!next_line()) throw Error(ErrorCode::unreadable_input, fmt::format("{}: the file has no text", *path_));
}

void TextScanner::fail(const std::string& reason) const {
    fail(ErrorCode::unreadable_input, reason);
}

void TextScanner::fail(ErrorCode code, const std::string& reason) const {
    throw Error(code, fmt::format("{}: line {}: {}", *path_, line_, reason));
}

void TextScanner::fail_word(const char* what, std::string_view word) const {
    if (!word.empty())
        fail(fmt::format("expected {}, found {}{}", what, quoted(word),
                         is_decimal_comma(word) ? "; numbers have a decimal point, not a comma" : ""));
    if (position_ == end_) fail(fmt::format("expected {}, but the file ends", what));
    fail(fmt::format("expected {}, but the line ends", what));
}

bool equals_ignoring_case(std::string_view word, std::string_view lower) {
    return std::equal(word.begin(), word.end(), lower.begin(), lower.end(), [](char a, char b) {
        return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
    });
}

}  // namespace clsdf

#include "field/numbers.hpp"

#include <algorithm>
#include <charconv>

namespace clsdf {
namespace {

constexpr std::string_view blanks = " \t\r\n";

template <class Number>
bool parse_all(std::string_view text, std::span<Number> numbers) {
    for (Number& number : numbers) {
        text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
        const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc()) return false;
        text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
        if (!text.empty() && blanks.find(text.front()) == std::string_view::npos) return false;
    }
    return text.find_first_not_of(blanks) == std::string_view::npos;
}

}  // namespace

bool parse_numbers(std::string_view text, std::span<double> numbers) {
    return parse_all(text, numbers);
}

bool parse_numbers(std::string_view text, std::span<std::int64_t> numbers) {
    return parse_all(text, numbers);
}

}  // namespace clsdf

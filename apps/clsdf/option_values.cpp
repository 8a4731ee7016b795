#include "option_values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string>

namespace {

template <class Number>
std::optional<Number> parse(const std::string& text) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || stop != end) return std::nullopt;
    return number;
}

}  // namespace

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
    return {[=](const std::string& text) {
                const auto number = parse<std::uint64_t>(text);
                if (number && *number >= least && *number <= most) return std::string();
                return fmt::format("a whole number from {} to {}, not '{}'", least, most, text);
            },
            ""};
}

CLI::Validator finite_number_of_0_or_more() {
    return {[](const std::string& text) {
                const auto number = parse<double>(text);
                if (number && std::isfinite(*number) && *number >= 0) return std::string();
                return fmt::format("a finite number, 0 or more, not '{}'", text);
            },
            ""};
}

CLI::Validator not_empty() {
    return {[](const std::string& text) { return text.empty() ? "the value is missing" : std::string(); }, ""};
}

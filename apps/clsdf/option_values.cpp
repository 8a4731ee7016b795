#include "option_values.hpp"

#include "core/real_numbers.hpp"
#include "core/text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
    std::string nearest;
    // If more than a third of the letters differ, it is another word, not a mistyped one.
    std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& candidate : known) {
        const bool is_beginning = word.size() > 3 && candidate.starts_with(word);
        const std::size_t distance = is_beginning ? 0 : clsdf::edit_distance(word, candidate);
        if (distance < least && distance < candidate.size()) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

std::string did_you_mean(const std::string& word) {
    return word.empty() ? std::string() : "; did you mean " + word + '?';
}

namespace {

template <class Number>
std::optional<Number> parse(const std::string& text) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = clsdf::read_number(text.data(), end, number);
    if (error != std::errc() || stop != end) return std::nullopt;
    return number;
}

CLI::Validator one_of(const std::vector<std::string>& words) {
    return {[=](const std::string& text) {
                if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
                return fmt::format("one of {}, not '{}'{}", fmt::join(words, ", "), text,
                                   did_you_mean(nearest_word(text, words)));
            },
            ""};
}

}  // namespace

void takes_one_of(CLI::Option* option, const std::vector<std::string>& words) {
    option->check(one_of(words))->type_name(fmt::format("{}", fmt::join(words, "|")));
}

void takes_some_of(CLI::Option* option, const std::vector<std::string>& words) {
    option->check(one_of(words))
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name(fmt::format("{},...", fmt::join(words, "|")));
}

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
    return {[=](std::string& text) {
                const auto number = parse<std::uint64_t>(text);
                if (!number || *number < least || *number > most)
                    return fmt::format("a whole number from {} to {}, not '{}'", least, most, text);
                text = fmt::to_string(*number);
                return std::string();
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

CLI::Validator file_name() {
    return {[](const std::string& text) {
                if (text.empty()) return std::string("the name of the file is missing");
                if (text != "-") return std::string();
                return std::string(
                    "standard input and output are not supported, because a file's ending chooses its format; "
                    "name a file (./- is one with that name)");
            },
            ""};
}

void keep_input(const std::string& input, const std::string& output, const std::string& what) {
    std::error_code ignored;
    if (std::filesystem::equivalent(input, output, ignored))
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("-o '{}' is the {} that is read; name another file", output, what));
}

clsdf::Error with_file(const clsdf::Error& error, std::string_view subject, const std::string& file) {
    if (!std::string_view(error.what()).starts_with(subject)) return error;
    const bool is_refused = error.code() == clsdf::ErrorCode::invalid_argument;
    return {is_refused ? clsdf::ErrorCode::unreadable_input : error.code(), fmt::format("{}: {}", file, error.what())};
}

clsdf::Outputs parse_outputs(const std::vector<std::string>& names) {
    clsdf::Outputs outputs;
    visit_extras(
        [&](const char* name, bool& wanted) { wanted = std::find(names.begin(), names.end(), name) != names.end(); },
        outputs);
    return outputs;
}

CLI::Option* add_outputs_option(CLI::App& parser, std::vector<std::string>& names) {
    std::vector<std::string> words;
    clsdf::visit_extras([&](const char* name, bool) { words.emplace_back(name); }, clsdf::Outputs());
    CLI::Option* option = parser.add_option("--with", names, "further outputs beside the distance");
    takes_some_of(option, words);
    return option;
}

CLI::Option* add_sign_option(CLI::App& parser, std::string& rule) {
    CLI::Option* option =
        parser.add_option("--sign", rule, "the rule that decides what is inside; none: no sign")->capture_default_str();
    takes_one_of(option, {"auto", "nonzero", "parity", "none"});
    return option;
}

clsdf::SignRule parse_sign(const std::string& rule) {
    using clsdf::SignRule;
    return value_named(rule, {SignRule::automatic, SignRule::nonzero, SignRule::parity, SignRule::none});
}

clsdf::Length parse_length(const std::string& option, const std::string& text) {
    using clsdf::Length;
    if (text == "full") return Length::infinite();

    std::string_view digits = text;
    Length::Unit unit = Length::Unit::mesh;
    if (digits.ends_with('%'))
        unit = Length::Unit::extent;
    else if (digits.ends_with('v'))
        unit = Length::Unit::voxels;
    if (unit != Length::Unit::mesh) digits.remove_suffix(1);

    double value = 0;
    const char* end = digits.data() + digits.size();
    const auto [stop, error] = clsdf::read_real(digits.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value) || value < 0)
        throw clsdf::Error(
            clsdf::ErrorCode::invalid_argument,
            fmt::format("{}: \"{}\" is not a length: write 10% (of the longest side of the mesh's box), 3v (voxels), "
                        "0.05 (the mesh's units) or full",
                        option, text));
    return {unit == Length::Unit::extent ? value / 100 : value, unit};
}

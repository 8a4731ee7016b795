#include "two_lines.hpp"

#include "core/real_numbers.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <regex>
#include <sstream>
#include <string_view>
#include <vector>

namespace {

constexpr std::size_t line_length = 100;
constexpr const char* indent = "  ";

/// The text broken at blanks; nothing if it takes more than two lines. A word that is longer than a line, as the name
/// of a file, stays whole.
std::optional<std::string> wrapped(const std::string& text) {
    std::istringstream words(text);
    std::string lines, line;
    bool is_second = false;
    for (std::string word; words >> word;) {
        if (!line.empty() && line.size() + 1 + word.size() > line_length) {
            if (is_second) return {};
            is_second = true;
            lines = line + '\n';
            line = indent + word;
        } else {
            line += (line.empty() ? "" : " ") + word;
        }
    }
    return lines + line;
}

/// "0.10000000000000001" -> "0.1".
std::string with_rounded_numbers(const std::string& text) {
    static const std::regex long_number(R"(-?[0-9]*\.[0-9]{7,}(e[-+]?[0-9]+)?)");
    std::string result;
    std::size_t end = 0;
    for (std::sregex_iterator match(text.begin(), text.end(), long_number), none; match != none; ++match) {
        const std::string digits = match->str();
        double value = 0;
        clsdf::read_real(digits.data(), digits.data() + digits.size(), value);
        const auto begin = static_cast<std::size_t>(match->position());
        result += text.substr(end, begin - end) + fmt::format("{:.6g}", value);
        end = begin + digits.size();
    }
    return result + text.substr(end);
}

std::string without_lists_of_edges(const std::string& text) {
    static const std::regex edges(R"(: \([^()]*\) to \([^()]*\)(, \([^()]*\) to \([^()]*\))*( and [0-9]+ more)?)");
    return std::regex_replace(text, edges, "");
}

/// "the sign rule none", "(weld())" -> "--sign none", "".
std::string in_words_of_the_command(const std::string& text) {
    static const std::regex function(R"( \([a-z_]+\(\)\))"),
        rule("the sign rule (nonzero|parity|solid-angle|below|none)"), floor(" with a floor Z");
    const std::string by_rule = std::regex_replace(std::regex_replace(text, function, ""), rule, "--sign $1");
    return std::regex_replace(by_rule, floor, " --floor Z");
}

/// The ends of clauses: at each "; " outside of brackets, and at the end of the text.
std::vector<std::size_t> ends_of_clauses(const std::string& text) {
    std::vector<std::size_t> ends;
    int depth = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
        if (depth <= 0 && std::string_view(text).substr(i).starts_with("; ")) ends.push_back(i);
    }
    ends.push_back(text.size());
    return ends;
}

/// With a mark that the text goes on.
std::optional<std::string> cut(const std::string& text) {
    for (const char* mark : {"; --verbose tells more", " ..."})
        if (auto lines = wrapped(text + mark)) return lines;
    return {};
}

}  // namespace

std::string two_lines_of(const std::string& warning) {
    const std::string shorter = without_lists_of_edges(warning);
    const std::string text = with_rounded_numbers(in_words_of_the_command(shorter));
    if (auto whole = wrapped(text)) return shorter == warning ? *whole : cut(text).value_or(*whole);
    const std::vector<std::size_t> ends = ends_of_clauses(text);
    for (auto end = ends.rbegin(); end != ends.rend(); ++end)
        if (auto lines = cut(text.substr(0, *end))) return *lines;
    // A first clause that is too long ends with a word.
    for (std::size_t end = text.rfind(' ', ends.front()); end != std::string::npos && end > 0;
         end = text.rfind(' ', end - 1))
        if (auto lines = wrapped(text.substr(0, end) + " ... (--verbose tells more)")) return lines.value();
    return text;
}

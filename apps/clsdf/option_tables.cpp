#include "option_tables.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <iterator>

namespace {

constexpr const char* end_mark = "<!-- end of options -->\n";

// In a table a vertical bar ends a cell, even between backticks.
std::string cell(const std::string& text) {
    std::string result;
    for (const char letter : text) {
        if (letter == '|') result += '\\';
        result += letter;
    }
    return result;
}

std::string row(const OptionDescription& option) {
    std::string names;
    for (const std::string& name : option.names)
        names += fmt::format("{}`{}{}`", names.empty() ? "" : ", ", name,
                             option.is_flag() || name != option.names.back() ? "" : ' ' + option.takes);
    if (names.empty()) names = '`' + option.takes + '`';
    const std::string default_text = option.default_text.empty() ? "" : cell(option.default_text) + ' ';
    return fmt::format("| {} | {} | {}|\n", cell(names), cell(option.text), default_text);
}

std::string table(const SubcommandDescription& subcommand) {
    std::string text = "| | | default |\n|-|-|-|\n";
    for (const OptionDescription& argument : subcommand.arguments) text += row(argument);
    for (const OptionDescription& option : subcommand.options())
        if (option.name() != "--help") text += row(option);
    return text;
}

}  // namespace

std::string with_option_tables(const std::string& document, const ProgramDescription& description) {
    std::string result = document;
    for (const SubcommandDescription& subcommand : description.subcommands) {
        const std::string mark = fmt::format("<!-- options of {} -->\n", subcommand.name);
        const std::size_t begin = result.find(mark);
        const std::size_t end = begin == std::string::npos ? begin : result.find(end_mark, begin);
        if (end == std::string::npos)
            throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                               fmt::format("the document lacks the marks for the options of {}: the lines {}and {}",
                                           subcommand.name, mark, end_mark));
        const std::size_t first = begin + mark.size();
        result.replace(first, end - first, table(subcommand));
    }
    return result;
}

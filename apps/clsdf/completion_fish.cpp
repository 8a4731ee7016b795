#include "completions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>

namespace {

std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char letter : text) {
        if (letter == '\'' || letter == '\\') result += '\\';
        result += letter;
    }
    return result + '\'';
}

// Options of fish's `complete` that complete the value.
std::string value(const OptionDescription& option) {
    if (!option.words.empty()) return fmt::format(" -x -a '{}'", fmt::join(option.words, " "));
    if (!option.is_file) return " -x";
    if (option.endings.empty()) return " -r -F";
    return fmt::format(" -x -k -a '(__clsdf_files {})'", fmt::join(option.endings, " "));
}

void append_option(std::string& text, const std::string& condition, const OptionDescription& option) {
    fmt::format_to(std::back_inserter(text), "complete -c clsdf -n {}", quoted(condition));
    for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.is_flag()) text += value(option);
    text += " -d " + quoted(option.text) + '\n';
}

}  // namespace

std::string fish_completion(const ProgramDescription& description) {
    std::string text = R"(# Completes clsdf in fish. Made from the options of the program by the build.

# Folders, and files with one of the endings.
function __clsdf_files
    set -l endings (string escape --style=regex -- $argv | string join '|')
    complete -C "__fish_command_without_completions "(commandline -ct) | string match -ier -- "(?:/|$endings)\$"
end

complete -c clsdf -f
)";
    for (const OptionDescription& option : description.program.options())
        append_option(text, "__fish_use_subcommand", option);
    for (const SubcommandDescription& subcommand : description.subcommands) {
        fmt::format_to(std::back_inserter(text), "\ncomplete -c clsdf -n __fish_use_subcommand -a {} -d {}\n",
                       subcommand.name, quoted(subcommand.text));
        const std::string condition = "__fish_seen_subcommand_from " + subcommand.name;
        for (const OptionDescription& option : subcommand.options()) append_option(text, condition, option);
        for (const OptionDescription& argument : subcommand.arguments)
            fmt::format_to(std::back_inserter(text), "complete -c clsdf -n {}{} -d {}\n", quoted(condition),
                           value(argument), quoted(argument.text));
    }
    return text;
}

#include "completions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>

namespace {

// For a text between single quotes in which _arguments gives the letters of `special` a meaning.
std::string quoted(const std::string& text, const std::string& special) {
    std::string result;
    for (const char letter : text) {
        if (letter == '\'') {
            result += "'\\''";
            continue;
        }
        if (special.find(letter) != std::string::npos) result += '\\';
        result += letter;
    }
    return result;
}

// ":FILE:_files -g ..." as _arguments takes it.
std::string value(const OptionDescription& option) {
    std::string action = " ";
    if (!option.words.empty()) {
        action = fmt::format("({})", fmt::join(option.words, " "));
        if (option.takes.ends_with(",..."))
            action = fmt::format("_sequence compadd - {}", fmt::join(option.words, " "));
    } else if (option.is_file) {
        action = "_files";
        for (const std::string& ending : option.endings) action += (action == "_files" ? " -g \"(#i)*(" : "|") + ending;
        if (!option.endings.empty()) action += ")\"";
    }
    return fmt::format(":{}:{}", quoted(option.takes, ":\\"), quoted(action, ""));
}

void append_option(std::string& text, const OptionDescription& option) {
    const std::string about = '[' + quoted(option.text, "[]\\") + ']' + (option.is_flag() ? "" : value(option));
    const bool ends = option.name() == "--help" || option.name() == "--version";
    for (const std::string& name : option.names) {
        const std::string others = ends ? "- *" : fmt::format("{}", fmt::join(option.names, " "));
        const char* joins = option.is_flag() ? "" : name.starts_with("--") ? "=" : "+";
        fmt::format_to(std::back_inserter(text), " \\\n                '({}){}{}{}'", others, name, joins, about);
    }
}

}  // namespace

std::string zsh_completion(const ProgramDescription& description) {
    std::string text =
        "#compdef clsdf\n"
        "# Completes clsdf in zsh. Made from the options of the program by the build.\n\n"
        "_clsdf() {\n"
        "    local curcontext=\"$curcontext\" state line\n"
        "    typeset -A opt_args\n"
        "    local -a subcommands=(\n";
    for (const SubcommandDescription& subcommand : description.subcommands)
        fmt::format_to(std::back_inserter(text), "        '{}:{}'\n", subcommand.name, quoted(subcommand.text, ":\\"));
    text +=
        "    )\n"
        "    _arguments -C";
    for (const OptionDescription& option : description.program.options()) append_option(text, option);
    text +=
        " \\\n                '1:SUBCOMMAND:->subcommand' '*::argument:->argument'\n"
        "    case $state in\n"
        "        subcommand)\n"
        "            _describe -t commands subcommand subcommands\n"
        "            ;;\n"
        "        argument)\n"
        "            case $words[1] in\n";
    for (const SubcommandDescription& subcommand : description.subcommands) {
        fmt::format_to(std::back_inserter(text), "            {})\n                _arguments", subcommand.name);
        for (const OptionDescription& option : subcommand.options()) append_option(text, option);
        for (std::size_t i = 0; i < subcommand.arguments.size(); ++i)
            fmt::format_to(std::back_inserter(text), " \\\n                '{}{}'", i + 1,
                           value(subcommand.arguments[i]));
        text += "\n                ;;\n";
    }
    text +=
        "            esac\n"
        "            ;;\n"
        "    esac\n"
        "}\n\n"
        "_clsdf \"$@\"\n";
    return text;
}

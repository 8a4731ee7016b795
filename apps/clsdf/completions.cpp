#include "documents.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>

namespace {

constexpr const char* bash_head = R"(# Completes clsdf in bash. Made from the options of the program by the build.

_clsdf_words() {
    COMPREPLY=($(compgen -W "$1" -- "$word"))
}

# Folders, and files with one of the endings; without endings every file.
_clsdf_files() {
    local IFS=$'\n' name ending
    compopt -o filenames 2> /dev/null
    COMPREPLY=($(compgen -d -- "$word"))
    for name in $(compgen -f -- "$word"); do
        [ -d "$name" ] && continue
        [ $# -eq 0 ] && COMPREPLY+=("$name")
        for ending; do
            [[ ${name,,} == *"$ending" ]] && COMPREPLY+=("$name")
        done
    done
}

_clsdf() {
    local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local subcommand='' place=0 skip='' i
    COMPREPLY=()
    # "--option=value" arrives as three words.
    if [[ $word == "=" ]]; then
        word=''
    elif [[ $previous == "=" && COMP_CWORD -gt 1 ]]; then
        previous=${COMP_WORDS[COMP_CWORD - 2]}
    fi
)";

std::string joined_names(const std::vector<OptionDescription>& options, const char* separator) {
    std::string text;
    for (const OptionDescription& option : options)
        for (const std::string& name : option.names) text += (text.empty() ? "" : separator) + name;
    return text;
}

// The command that completes the value; ":" if there are no candidates.
std::string bash_completer(const OptionDescription& option) {
    if (!option.words.empty()) return fmt::format("_clsdf_words '{}'", fmt::join(option.words, " "));
    if (option.is_file) return fmt::format("_clsdf_files {}", fmt::join(option.endings, " "));
    return ":";
}

void append_bash_values(std::string& text, const SubcommandDescription& subcommand) {
    for (const OptionDescription& option : subcommand.options()) {
        if (option.is_flag()) continue;
        std::string patterns;
        for (const std::string& name : option.names)
            patterns += (patterns.empty() ? "" : " | ") + subcommand.name + ':' + name;
        fmt::format_to(std::back_inserter(text), "        {})\n            {}\n            return\n            ;;\n",
                       patterns, bash_completer(option));
    }
}

void append_bash_options(std::string& text, const SubcommandDescription& subcommand, const std::string& pattern) {
    fmt::format_to(std::back_inserter(text), "        {}:*)\n            _clsdf_words '{}'\n            ;;\n", pattern,
                   joined_names(subcommand.options(), " "));
}

}  // namespace

std::string bash_completion(const ProgramDescription& description) {
    std::string names;
    std::string values;
    std::string arguments;
    std::string options;
    std::string taking;
    for (const SubcommandDescription& subcommand : description.subcommands) {
        names += (names.empty() ? "" : " ") + subcommand.name;
        append_bash_values(values, subcommand);
        append_bash_options(options, subcommand, subcommand.name);
        for (std::size_t i = 0; i < subcommand.arguments.size(); ++i)
            fmt::format_to(std::back_inserter(arguments), "        {}:{})\n            {}\n            ;;\n",
                           subcommand.name, subcommand.arguments[i].repeats ? "*" : fmt::to_string(i),
                           bash_completer(subcommand.arguments[i]));
        for (const OptionDescription& option : subcommand.options())
            if (!option.is_flag())
                for (const std::string& name : option.names)
                    taking += (taking.empty() ? "" : " | ") + subcommand.name + ':' + name;
    }
    append_bash_options(options, description.program, "");

    std::string text = bash_head;
    fmt::format_to(std::back_inserter(text),
                   "    # The subcommand, and how many of its arguments are there already.\n"
                   "    for ((i = 1; i < COMP_CWORD; i++)); do\n"
                   "        if [[ -n $skip ]]; then\n"
                   "            [[ ${{COMP_WORDS[i]}} == \"=\" ]] || skip=''\n"
                   "            continue\n"
                   "        fi\n"
                   "        case $subcommand:${{COMP_WORDS[i]}} in\n"
                   "            {})\n"
                   "                skip=1\n"
                   "                ;;\n"
                   "            *:-*) ;;\n"
                   "            :*)\n"
                   "                subcommand=${{COMP_WORDS[i]}}\n"
                   "                ;;\n"
                   "            *)\n"
                   "                place=$((place + 1))\n"
                   "                ;;\n"
                   "        esac\n"
                   "    done\n"
                   "    case $subcommand:$previous in\n"
                   "{}"
                   "    esac\n"
                   "    if [[ $word != -* ]]; then\n"
                   "        case $subcommand:$place in\n"
                   "        :0)\n"
                   "            _clsdf_words '{}'\n"
                   "            ;;\n"
                   "{}"
                   "        esac\n"
                   "        return\n"
                   "    fi\n"
                   "    case $subcommand:$word in\n"
                   "{}"
                   "    esac\n"
                   "}}\n"
                   "complete -F _clsdf clsdf\n",
                   taking, values, names, arguments, options);
    return text;
}

namespace {

// For a text between single quotes in which _arguments gives the letters of `special` a meaning.
std::string zsh_quoted(const std::string& text, const std::string& special) {
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
std::string zsh_value(const OptionDescription& option) {
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
    return fmt::format(":{}:{}", zsh_quoted(option.takes, ":\\"), zsh_quoted(action, ""));
}

void append_zsh_option(std::string& text, const OptionDescription& option) {
    const std::string about = '[' + zsh_quoted(option.text, "[]\\") + ']' + (option.is_flag() ? "" : zsh_value(option));
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
        fmt::format_to(std::back_inserter(text), "        '{}:{}'\n", subcommand.name,
                       zsh_quoted(subcommand.text, ":\\"));
    text +=
        "    )\n"
        "    _arguments -C";
    for (const OptionDescription& option : description.program.options()) append_zsh_option(text, option);
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
        for (const OptionDescription& option : subcommand.options()) append_zsh_option(text, option);
        for (std::size_t i = 0; i < subcommand.arguments.size(); ++i)
            fmt::format_to(std::back_inserter(text), " \\\n                '{}{}'",
                           subcommand.arguments[i].repeats ? "*" : fmt::to_string(i + 1),
                           zsh_value(subcommand.arguments[i]));
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

namespace {

std::string fish_quoted(const std::string& text) {
    std::string result = "'";
    for (const char letter : text) {
        if (letter == '\'' || letter == '\\') result += '\\';
        result += letter;
    }
    return result + '\'';
}

// Options of fish's `complete` that complete the value.
std::string fish_value(const OptionDescription& option) {
    if (!option.words.empty()) return fmt::format(" -x -a '{}'", fmt::join(option.words, " "));
    if (!option.is_file) return " -x";
    if (option.endings.empty()) return " -r -F";
    return fmt::format(" -x -k -a '(__clsdf_files {})'", fmt::join(option.endings, " "));
}

void append_fish_option(std::string& text, const std::string& condition, const OptionDescription& option) {
    fmt::format_to(std::back_inserter(text), "complete -c clsdf -n {}", fish_quoted(condition));
    for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.is_flag()) text += fish_value(option);
    text += " -d " + fish_quoted(option.text) + '\n';
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
        append_fish_option(text, "__fish_use_subcommand", option);
    for (const SubcommandDescription& subcommand : description.subcommands) {
        fmt::format_to(std::back_inserter(text), "\ncomplete -c clsdf -n __fish_use_subcommand -a {} -d {}\n",
                       subcommand.name, fish_quoted(subcommand.text));
        const std::string condition = "__fish_seen_subcommand_from " + subcommand.name;
        for (const OptionDescription& option : subcommand.options()) append_fish_option(text, condition, option);
        for (const OptionDescription& argument : subcommand.arguments)
            fmt::format_to(std::back_inserter(text), "complete -c clsdf -n {}{} -d {}\n", fish_quoted(condition),
                           fish_value(argument), fish_quoted(argument.text));
    }
    return text;
}

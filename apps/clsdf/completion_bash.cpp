#include "completions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>

namespace {

constexpr const char* head = R"(# Completes clsdf in bash. Made from the options of the program by the build.

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
std::string completer(const OptionDescription& option) {
    if (!option.words.empty()) return fmt::format("_clsdf_words '{}'", fmt::join(option.words, " "));
    if (option.is_file) return fmt::format("_clsdf_files {}", fmt::join(option.endings, " "));
    return ":";
}

void append_values(std::string& text, const SubcommandDescription& subcommand) {
    for (const OptionDescription& option : subcommand.options()) {
        if (option.is_flag()) continue;
        std::string patterns;
        for (const std::string& name : option.names)
            patterns += (patterns.empty() ? "" : " | ") + subcommand.name + ':' + name;
        fmt::format_to(std::back_inserter(text), "        {})\n            {}\n            return\n            ;;\n",
                       patterns, completer(option));
    }
}

void append_options(std::string& text, const SubcommandDescription& subcommand, const std::string& pattern) {
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
        append_values(values, subcommand);
        append_options(options, subcommand, subcommand.name);
        for (std::size_t i = 0; i < subcommand.arguments.size(); ++i)
            fmt::format_to(std::back_inserter(arguments), "        {}:{})\n            {}\n            ;;\n",
                           subcommand.name, i, completer(subcommand.arguments[i]));
        for (const OptionDescription& option : subcommand.options())
            if (!option.is_flag())
                for (const std::string& name : option.names)
                    taking += (taking.empty() ? "" : " | ") + subcommand.name + ':' + name;
    }
    append_options(options, description.program, "");

    std::string text = head;
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

#include "documents.hpp"

#include "option_values.hpp"
#include "report.hpp"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

namespace {

bool is_small_letter(char letter) {
    return letter >= 'a' && letter <= 'z';
}

// "nonzero|parity,..." -> nonzero, parity; nothing for "INDEX|NAME".
std::vector<std::string> typed_words(std::string_view takes) {
    if (takes.ends_with(",...")) takes.remove_suffix(4);
    std::vector<std::string> words;
    if (std::none_of(takes.begin(), takes.end(), is_small_letter)) return words;
    std::istringstream stream{std::string(takes)};
    for (std::string word; std::getline(stream, word, '|');) words.push_back(word);
    return words;
}

std::vector<std::string> known_words(const std::string& takes, const CLI::App& program) {
    std::vector<std::string> words = typed_words(takes);
    if (takes == "SHAPE")
        for (const clsdf::ShapeName& shape : clsdf::shape_names()) words.push_back(shape.name);
    if (takes == "SUBCOMMAND")
        for (const CLI::App* subcommand : program.get_subcommands([](const CLI::App*) { return true; }))
            if (!subcommand->get_group().empty()) words.push_back(subcommand->get_name());
    return words;
}

// "the mesh: .off or .obj" -> .off, .obj
std::vector<std::string> endings_in(const std::string& text) {
    const auto is_part = [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)) != 0; };
    std::vector<std::string> endings;
    for (std::size_t dot = text.find('.'); dot != std::string::npos; dot = text.find('.', dot + 1)) {
        const auto begin = text.begin() + static_cast<std::ptrdiff_t>(dot) + 1;
        const auto end = std::find_if_not(begin, text.end(), is_part);
        if (begin != end && (dot == 0 || text[dot - 1] == ' ')) endings.emplace_back(begin - 1, end);
    }
    return endings;
}

OptionDescription describe(const CLI::Option& option, const CLI::App& program) {
    OptionDescription result;
    for (const std::string& name : option.get_snames()) result.names.push_back('-' + name);
    for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
    if (option.get_positional())
        result.takes = option.get_name(true);
    else if (option.get_items_expected_max() > 0)
        result.takes = option.get_type_name();
    result.text = option.get_description();
    result.default_text = option.get_default_str();
    // "the slice's index [the middle]": a default that is no value.
    if (const std::size_t bracket = result.text.rfind(" [");
        bracket != std::string::npos && result.text.back() == ']') {
        result.default_text = result.text.substr(bracket + 2, result.text.size() - bracket - 3);
        result.text.resize(bracket);
    }
    result.required = option.get_required();
    result.words = known_words(result.takes, program);
    if (result.words.empty()) result.words = known_words(option.get_type_name(), program);
    for (const char* file : file_placeholders) result.is_file = result.is_file || result.takes == file;
    if (result.is_file) result.endings = endings_in(result.text);
    return result;
}

std::vector<std::string> paragraphs_of(const std::string& text) {
    std::vector<std::string> paragraphs(1);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty()) {
            paragraphs.emplace_back();
        } else {
            if (!paragraphs.back().empty()) paragraphs.back() += ' ';
            paragraphs.back() += line;
        }
    }
    std::erase(paragraphs, std::string());
    return paragraphs;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> result;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line) && !line.empty();)
        result.push_back(line.substr(std::min(line.find_first_not_of(' '), line.size())));
    return result;
}

SubcommandDescription describe_one(const CLI::App& parser, const CLI::App& program) {
    static const std::string examples_begin = "Examples:\n";
    SubcommandDescription result;
    result.name = parser.get_name();
    result.text = parser.get_description();
    for (const CLI::Option* option : parser.get_options()) {
        if (option->get_group().empty()) continue;
        if (option->get_positional()) {
            result.arguments.push_back(describe(*option, program));
            continue;
        }
        const auto group = std::find_if(result.groups.begin(), result.groups.end(), [&](const OptionGroup& candidate) {
            return candidate.title == option->get_group();
        });
        OptionGroup& place =
            group == result.groups.end() ? result.groups.emplace_back(OptionGroup{option->get_group(), {}}) : *group;
        place.options.push_back(describe(*option, program));
    }
    const std::string footer = parser.get_footer();
    const std::size_t examples = footer.find(examples_begin);
    result.explanation = paragraphs_of(footer.substr(0, std::min(examples, footer.find(exit_status_help()))));
    if (examples != std::string::npos) result.examples = lines_of(footer.substr(examples + examples_begin.size()));
    return result;
}

}  // namespace

std::vector<OptionDescription> SubcommandDescription::options() const {
    std::vector<OptionDescription> result;
    for (const OptionGroup& group : groups) result.insert(result.end(), group.options.begin(), group.options.end());
    return result;
}

ProgramDescription describe(const CLI::App& program) {
    ProgramDescription result{describe_one(program, program), {}};
    for (const CLI::App* subcommand : program.get_subcommands([](const CLI::App*) { return true; }))
        if (!subcommand->get_group().empty()) result.subcommands.push_back(describe_one(*subcommand, program));
    return result;
}

#include "command.hpp"
#include "documents.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
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

std::vector<std::string> known_words(const std::string& takes, const Parser& program) {
    std::vector<std::string> words = typed_words(takes);
    if (takes == "SHAPE")
        for (const clsdf::ShapeName& shape : clsdf::shape_names()) words.push_back(shape.name);
    if (takes == "SUBCOMMAND")
        for (const Parser& subcommand : program.subcommands()) words.push_back(subcommand.name());
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

OptionDescription describe(const Option& option, const Parser& program) {
    OptionDescription result;
    result.names = option.names();
    result.takes = option.takes();
    result.text = option.text();
    result.default_text = option.default_text();
    // "the slice's index [the middle]": a default that is no value.
    if (const std::size_t bracket = result.text.rfind(" [");
        bracket != std::string::npos && result.text.back() == ']') {
        result.default_text = result.text.substr(bracket + 2, result.text.size() - bracket - 3);
        result.text.resize(bracket);
    }
    result.usage = option.usage();
    result.repeats = option.repeats();
    result.words = known_words(result.takes, program);
    if (result.words.empty()) result.words = known_words(option.placeholder(), program);
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

SubcommandDescription describe_one(const Parser& parser, const Parser& program) {
    static const std::string examples_begin = "Examples:\n";
    SubcommandDescription result;
    result.name = parser.name();
    result.text = parser.text();
    for (const Option& option : parser.options()) {
        if (option.names().empty()) {
            result.arguments.push_back(describe(option, program));
            continue;
        }
        const auto group = std::find_if(result.groups.begin(), result.groups.end(), [&](const OptionGroup& candidate) {
            return candidate.title == option.group();
        });
        OptionGroup& place =
            group == result.groups.end() ? result.groups.emplace_back(OptionGroup{option.group(), {}}) : *group;
        place.options.push_back(describe(option, program));
    }
    // Further files of a mesh may stand where the last argument does.
    for (const OptionDescription& argument : result.arguments)
        if (argument.usage.ends_with("...") && !argument.repeats) {
            std::vector<std::string>& endings = result.arguments.back().endings;
            endings.insert(endings.end(), argument.endings.begin(), argument.endings.end());
        }
    const std::string footer = parser.footer();
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

ProgramDescription describe(const Parser& program) {
    ProgramDescription result{describe_one(program, program), {}};
    for (const Parser& subcommand : program.subcommands())
        result.subcommands.push_back(describe_one(subcommand, program));
    return result;
}

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

namespace {

namespace fs = std::filesystem;

struct GenerateOptions {
    std::string manual;
    std::string completions;
    std::string tables;
};

void write(const fs::path& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw clsdf::Error(clsdf::ErrorCode::output_failure, fmt::format("{} cannot be written", path.string()));
}

std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw clsdf::Error(clsdf::ErrorCode::unreadable_input, fmt::format("{} cannot be read", path.string()));
    return {std::istreambuf_iterator<char>(file), {}};
}

ExitStatus run(const GenerateOptions& options, const ProgramDescription& description) {
    if (!options.manual.empty())
        for (const ManualPage& page : manual_pages(description)) write(fs::path(options.manual) / page.file, page.text);
    if (!options.completions.empty()) {
        const fs::path folder = options.completions;
        write(folder / "clsdf", bash_completion(description));
        write(folder / "_clsdf", zsh_completion(description));
        write(folder / "clsdf.fish", fish_completion(description));
    }
    if (!options.tables.empty()) write(options.tables, with_option_tables(read(options.tables), description));
    return ExitStatus::done;
}

}  // namespace

/// For the build and for those who write the documents; no help page lists it.
Command add_generate(Parser& program) {
    const auto options = std::make_shared<GenerateOptions>();
    Parser parser = program.add_subcommand("generate", "Make manual pages, completions and tables from the options");
    parser.hide();
    parser.add("--manual", options->manual, "the folder of the manual pages").takes("FOLDER");
    parser.add("--completions", options->completions, "the folder of the completions: clsdf (bash), _clsdf, clsdf.fish")
        .takes("FOLDER");
    parser.add("--tables", options->tables, "a document whose tables of options are made anew").takes("DOCUMENT");
    parser.set_footer(
        "Examples:\n"
        "  clsdf generate --tables docs/command.md");
    return {parser, [program, options](Report&) { return run(*options, describe(program)); }};
}

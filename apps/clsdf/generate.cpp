#include "command.hpp"
#include "documents.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

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
Command add_generate(CLI::App& program) {
    const auto options = std::make_shared<GenerateOptions>();
    CLI::App* parser = program.add_subcommand("generate", "Make manual pages, completions and tables from the options");
    parser->group("");
    parser->add_option("--manual", options->manual, "the folder of the manual pages")->type_name("FOLDER");
    parser
        ->add_option("--completions", options->completions,
                     "the folder of the completions: clsdf (bash), _clsdf, clsdf.fish")
        ->type_name("FOLDER");
    parser->add_option("--tables", options->tables, "a document whose tables of options are made anew")
        ->type_name("DOCUMENT");
    parser->footer(
        "Examples:\n"
        "  clsdf generate --tables docs/command.md");
    return {parser, [&program, options](Report&) { return run(*options, describe(program)); }};
}

#include "command.hpp"
#include "completions.hpp"
#include "description.hpp"
#include "manual.hpp"
#include "option_tables.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

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

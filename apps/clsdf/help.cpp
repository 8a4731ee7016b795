#include "command.hpp"
#include "output.hpp"
#include "suggestion.hpp"

#include <memory>

namespace {

void print_page(const CLI::App& parser, const std::string& name) {
    print_result(parser.get_formatter()->make_help(&parser, name, CLI::AppFormatMode::Normal));
}

}  // namespace

Command add_help(CLI::App& program) {
    const auto name = std::make_shared<std::string>();
    CLI::App* parser = program.add_subcommand("help", "Print the help page of a subcommand");
    parser->add_option("SUBCOMMAND", *name, "the subcommand; without one, the page that lists them");
    parser->footer(
        "Examples:\n"
        "  clsdf help compute\n"
        "  clsdf help");
    return {parser, [&program, name](Report&) {
                if (name->empty()) {
                    print_page(program, "clsdf");
                    return ExitStatus::done;
                }
                std::vector<std::string> names;
                for (const CLI::App* subcommand : program.get_subcommands([](const CLI::App*) { return true; })) {
                    if (subcommand->get_group().empty()) continue;
                    names.push_back(subcommand->get_name());
                    if (names.back() != *name) continue;
                    print_page(*subcommand, "clsdf " + *name);
                    return ExitStatus::done;
                }
                throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                                   fmt::format("unknown subcommand {}{}\n\"clsdf --help\" lists the subcommands.",
                                               *name, did_you_mean(nearest_word(*name, names))));
            }};
}

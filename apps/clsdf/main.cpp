#include "command.hpp"
#include "interruption.hpp"
#include "suggestion.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <cstdio>
#include <new>

namespace {

// "--resolution N [256]": what an option takes and its default, without what excludes what.
class HelpFormatter : public CLI::Formatter {
public:
    HelpFormatter() { column_width(28); }

    std::string make_option_opts(const CLI::Option* option) const override {
        std::string text;
        if (!option->get_type_name().empty() && !option->get_positional()) text += ' ' + option->get_type_name();
        if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + ']';
        return text;
    }
};

std::vector<std::string> known_words(const CLI::App& parser) {
    std::vector<std::string> words;
    for (const CLI::App* subcommand : parser.get_subcommands([](const CLI::App*) { return true; }))
        words.push_back(subcommand->get_name());
    for (const CLI::Option* option : parser.get_options())
        for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
    return words;
}

// "bench peers" is a subcommand of a subcommand: the innermost that was parsed.
const CLI::App& parser_in_use(const CLI::App& program) {
    const CLI::App* parser = &program;
    while (!parser->get_subcommands().empty()) parser = parser->get_subcommands().front();
    return *parser;
}

// The first word that no option and no subcommand took, and what was probably meant by it.
std::string explain_unknown_word(const CLI::App& program) {
    const CLI::App& parser = parser_in_use(program);
    for (const std::string& argument : parser.remaining()) {
        const std::string word = argument.substr(0, argument.find('='));
        const std::string meant = nearest_word(word, known_words(parser));
        const char* what = word.starts_with('-')                                                  ? "option"
                           : parser.get_subcommands([](const CLI::App*) { return true; }).empty() ? "argument"
                                                                                                  : "subcommand";
        return fmt::format("unknown {} {}{}", what, word,
                           meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
    }
    return {};
}

ExitStatus explain(const CLI::App& program, const CLI::ParseError& error) {
    std::string path;
    for (const CLI::App* parser = &parser_in_use(program); parser != &program; parser = parser->get_parent())
        path = parser->get_name() + ' ' + path;
    const std::string unknown = explain_unknown_word(program);
    fmt::print(stderr, "clsdf: {}\n", unknown.empty() ? error.what() : unknown);
    fmt::print(stderr, "\"clsdf {}--help\" lists what there is.\n", path);
    return ExitStatus::usage;
}

ExitStatus run(int argument_count, char** arguments) {
    CLI::App program("Exact signed distance fields of triangle meshes on regular grids, with OpenCL.", "clsdf");
    program.formatter(std::make_shared<HelpFormatter>());
    program.set_help_flag("-h,--help", "print this page");
    program.set_version_flag("--version", "clsdf " + clsdf::version(), "print the version");
    program.require_subcommand(1);
    program.footer(std::string("\"clsdf SUBCOMMAND --help\" has the options and examples of each.\n\n"
                               "Examples:\n"
                               "  clsdf compute bunny.off -o bunny.nrrd\n"
                               "  clsdf check bunny.off bunny.nrrd\n"
                               "  clsdf slice bunny.nrrd -o bunny.png\n"
                               "  clsdf render bunny.nrrd -o surface.png\n"
                               "  clsdf info bunny.off\n"
                               "  clsdf shape sphere6 -o sphere6.off\n"
                               "  clsdf polyhedra bunny.off -o polyhedra.ply\n"
                               "  clsdf devices\n"
                               "  clsdf bench peers\n\n") +
                   exit_status_help());
    const std::vector<Command> commands{add_compute(program),   add_check(program),   add_info(program),
                                        add_slice(program),     add_render(program),  add_shape(program),
                                        add_polyhedra(program), add_devices(program), add_bench(program)};
    for (const Command& command : commands)
        command.parser->footer(command.parser->get_footer() + "\n\n" + exit_status_help());

    try {
        program.parse(argument_count, arguments);
    } catch (const CLI::Success& request) {  // --help or --version
        program.exit(request);
        return ExitStatus::done;
    } catch (const CLI::ParseError& error) {
        return explain(program, error);
    }
    for (const Command& command : commands)
        if (command.parser->parsed()) return command.run();
    return ExitStatus::usage;
}

}  // namespace

int main(int argument_count, char** arguments) {
    end_when_interrupted();
    ExitStatus status = ExitStatus::device;
    try {
        status = run(argument_count, arguments);
    } catch (const clsdf::Error& error) {
        fmt::print(stderr, "clsdf: {}\n", error.what());
        status = status_of(error.code());
    } catch (const std::bad_alloc&) {
        fmt::print(stderr,
                   "clsdf: the memory is too small for this; choose a lower --resolution or a larger --spacing\n");
    } catch (const std::exception& error) {
        fmt::print(stderr, "clsdf: internal error: {}\n", error.what());
    }
    return static_cast<int>(status);
}

#include "command.hpp"
#include "commit.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "subcommands.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

using clsdf::Error;
using clsdf::ErrorCode;

Command add_help(CLI::App& program);
Command add_generate(CLI::App& program);

namespace {

/// All subcommands, and the parts that they share.
class CommandLine {
public:
    explicit CommandLine(Report& report);
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// Throws clsdf::Error; invalid_argument if a word is not valid, with the nearest valid one in the message.
    ExitStatus run(int argument_count, char** arguments);

private:
    void add(const Command& command);
    void add_common_options(const Command& command);

    Report& report_;
    CLI::App program_;
    std::vector<Command> commands_;
};

// "--resolution N [256]": an option's type and its default, without the list of options that it excludes.
class HelpFormatter : public CLI::Formatter {
public:
    HelpFormatter() { column_width(28); }

    std::string make_option_opts(const CLI::Option* option) const override {
        std::string text;
        if (!option->get_type_name().empty() && !option->get_positional()) text += ' ' + option->get_type_name();
        if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + ']';
        return text;
    }

    // With one empty line between groups, not two.
    std::string make_help(const CLI::App* parser, std::string name, CLI::AppFormatMode mode) const override {
        std::string text = CLI::Formatter::make_help(parser, std::move(name), mode);
        for (std::size_t at = text.find("\n\n\n"); at != std::string::npos; at = text.find("\n\n\n", at))
            text.erase(at, 1);
        return text;
    }

    // Without "exactly one of the following is required".
    std::string make_description(const CLI::App* parser) const override { return parser->get_description() + ".\n"; }
};

std::vector<std::string> known_words(const CLI::App& parser) {
    std::vector<std::string> words;
    for (const CLI::App* subcommand : parser.get_subcommands([](const CLI::App*) { return true; }))
        if (!subcommand->get_group().empty()) words.push_back(subcommand->get_name());
    for (const CLI::Option* option : parser.get_options())
        for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
    return words;
}

// The first word that no option and no subcommand took, and the probable meaning.
std::string explain_unknown_word(const CLI::App& program) {
    const auto chosen = program.get_subcommands();
    const CLI::App& parser = chosen.empty() ? program : *chosen.front();
    for (const std::string& argument : parser.remaining()) {
        const std::string word = argument.substr(0, argument.find('='));
        const char* what = word.starts_with('-') ? "option" : chosen.empty() ? "subcommand" : "argument";
        return fmt::format("unknown {} {}{}", what, word, did_you_mean(nearest_word(word, known_words(parser))));
    }
    return {};
}

std::string explain(const CLI::ParseError& error) {
    // "--resolution: 1 required N missing"
    const std::string text = error.what();
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && text.ends_with(" missing"))
        return text.substr(0, text.find(':')) + ": the value is missing";
    return text;
}

/// CLI11 would take the next argument as the value of "--name=".
void refuse_missing_values(std::span<char* const> arguments) {
    for (const std::string_view argument : arguments) {
        if (argument == "--") return;
        if (argument.starts_with("--") && argument.find('=') == argument.size() - 1)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("{}: the value is missing", argument.substr(0, argument.size() - 1)));
    }
}

Error usage_error(const CLI::App& program, const CLI::ParseError& error) {
    const auto chosen = program.get_subcommands();
    const std::string unknown = explain_unknown_word(program);
    return {ErrorCode::invalid_argument,
            fmt::format("{}\n\"clsdf {}--help\" lists the options.", unknown.empty() ? explain(error) : unknown,
                        chosen.empty() ? "" : chosen.front()->get_name() + ' ')};
}

/// "clsdf 0.1.0", with the commit if the sources were under version control, and the libraries of the build.
std::string version_text() {
    const std::string commit = CLSDF_COMMIT;
    return fmt::format(
        "clsdf {}{}\nbuilt with {} {}, CGAL {}, Eigen {}, cairo {}\n\"clsdf devices\" lists the OpenCL drivers.",
        clsdf::version(), commit.empty() ? "" : " (" + commit + ")", CLSDF_COMPILER, CLSDF_COMPILER_VERSION,
        CLSDF_CGAL_VERSION, CLSDF_EIGEN_VERSION, CLSDF_CAIRO_VERSION);
}

bool takes_a_file(const CLI::Option& option) {
    const std::string takes = option.get_positional() ? option.get_name(true) : option.get_type_name();
    return std::find(file_placeholders.begin(), file_placeholders.end(), takes) != file_placeholders.end();
}

void print_page(const CLI::App& parser, const std::string& name) {
    print_result(parser.get_formatter()->make_help(&parser, name, CLI::AppFormatMode::Normal));
}

}  // namespace

CommandLine::CommandLine(Report& report)
    : report_(report), program_("Exact signed distance fields of triangle meshes on regular grids", "clsdf") {
    program_.formatter(std::make_shared<HelpFormatter>());
    program_.set_help_flag("-h,--help", "print this page");
    program_.set_version_flag("--version", version_text,
                              "print the version, the commit and the libraries of the build");
    program_.require_subcommand(1);
    program_.footer(std::string("\"clsdf help SUBCOMMAND\" has the options and examples of each.\n\n"
                                "Examples:\n"
                                "  clsdf shape knot -o knot.off\n"
                                "  clsdf compute knot.off -o knot.nrrd\n"
                                "  clsdf check knot.off knot.nrrd\n"
                                "  clsdf slice knot.nrrd -o knot.png\n"
                                "  clsdf render knot.nrrd -o surface.png\n"
                                "  clsdf info knot.off\n"
                                "  clsdf devices\n\n") +
                    exit_status_help());
    for (const auto add_subcommand : subcommands) {
        const Command command = add_subcommand(program_);
        add_common_options(command);
        add(command);
    }
    add(add_help(program_));
    add(add_generate(program_));
}

void CommandLine::add(const Command& command) {
    for (CLI::Option* option : command.parser->get_options())
        if (takes_a_file(*option)) option->check(file_name());
    const std::string footer = command.parser->get_footer();
    command.parser->footer(footer + (footer.empty() ? "" : "\n\n") + exit_status_help());
    commands_.push_back(command);
}

void CommandLine::add_common_options(const Command& command) {
    command.parser->add_flag("--json", report_.json, "print the result, or the error, as JSON on standard output");
    command.parser->add_flag("--quiet", report_.quiet, "print warnings and errors only");
}

ExitStatus CommandLine::run(int argument_count, char** arguments) {
    if (argument_count <= 1) {
        print_text("{}", program_.help());
        return ExitStatus::usage;
    }
    refuse_missing_values(std::span(arguments, static_cast<std::size_t>(argument_count)).subspan(1));
    try {
        program_.parse(argument_count, arguments);
    } catch (const CLI::CallForVersion& request) {
        report_.json = false;  // the text is the result
        print_result(std::string(request.what()) + '\n');
        return ExitStatus::done;
    } catch (const CLI::CallForHelp&) {
        report_.json = false;
        print_result(program_.help());  // the subcommand's page, if there is one
        return ExitStatus::done;
    } catch (const CLI::ParseError& error) {
        throw usage_error(program_, error);
    }
    for (const Command& command : commands_)
        if (command.parser->parsed()) return command.run(report_);
    return ExitStatus::usage;
}

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
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("unknown subcommand {}{}\n\"clsdf --help\" lists the subcommands.", *name,
                                        did_you_mean(nearest_word(*name, names))));
            }};
}

namespace {

// Found before the command line is parsed, because its errors are JSON, too.
bool asks_for_json(int argument_count, char** arguments) {
    char** const end = std::find(arguments, arguments + argument_count, std::string_view("--"));
    return std::find(arguments, end, std::string_view("--json")) != end;
}

}  // namespace

int main(int argument_count, char** arguments) {
    open_closed_streams();
    let_writes_fail();
    Report report;
    report.json = asks_for_json(argument_count, arguments);
    end_when_left_by_a_library(report.json);
    ExitStatus status = ExitStatus::device;
    try {
        end_when_interrupted(report.json);
        status = CommandLine(report).run(argument_count, arguments);
        report.finish();
    } catch (const clsdf::Error& error) {
        if (interrupted() && error.code() != ErrorCode::cancelled) {
            // A signal is ending the process and made the call fail.
            std::this_thread::sleep_for(std::chrono::seconds(1));
            status = report.fail(ErrorCode::cancelled, "cancelled; nothing was written");
        } else {
            status = report.fail(error.code(), error.what());
        }
    } catch (const std::bad_alloc&) {
        status = report.fail(ErrorCode::out_of_memory,
                             "the memory is too small for this; choose a lower --resolution or a larger --spacing");
    } catch (const std::exception& error) {
        status = report.fail(ErrorCode::device_failure, std::string("internal error: ") + error.what());
    }
    ignore_interruptions();
    return static_cast<int>(status);
}

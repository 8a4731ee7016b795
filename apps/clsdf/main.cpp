#include "command.hpp"
#include "commit.hpp"
#include "interruption.hpp"
#include "nearest_word.hpp"
#include "report.hpp"
#include "subcommands.hpp"

#include <clsdf/error.hpp>
#include <clsdf/tuning.hpp>
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

Command add_help(Parser& program);
Command add_generate(Parser& program);
Command add_compile_ahead(Parser& program);

namespace {

/// All subcommands, and the parts that they share.
class CommandLine {
public:
    explicit CommandLine(Report& report);
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// Throws clsdf::Error.
    ExitStatus run(int argument_count, char** arguments);

private:
    void add(Command command);
    void add_common_options(Parser& parser);

    Report& report_;
    Parser program_;
    std::vector<Command> commands_;
};

/// "clsdf 0.1.0", with the commit if the sources were under version control, and the libraries of the build.
std::string version_text() {
    const std::string commit = CLSDF_COMMIT;
    return fmt::format(
        "clsdf {}{}\nbuilt with {} {}, CGAL {}, Eigen {}, cairo {}\n\"clsdf devices\" lists the OpenCL drivers.",
        clsdf::version(), commit.empty() ? "" : " (" + commit + ")", CLSDF_COMPILER, CLSDF_COMPILER_VERSION,
        CLSDF_CGAL_VERSION, CLSDF_EIGEN_VERSION, CLSDF_CAIRO_VERSION);
}

}  // namespace

CommandLine::CommandLine(Report& report)
    : report_(report), program_("clsdf", "Exact signed distance fields of triangle meshes on regular grids") {
    program_.add_version(version_text(), "print the version, the commit and the libraries of the build");
    program_.set_footer(std::string("\"clsdf help SUBCOMMAND\" has the options and examples of each.\n\n"
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
        Command command = add_subcommand(program_);
        add_common_options(command.parser);
        add(command);
    }
    add(add_help(program_));
    add(add_generate(program_));
    add(add_compile_ahead(program_));
}

void CommandLine::add(Command command) {
    const std::string footer = command.parser.footer();
    command.parser.set_footer(footer + (footer.empty() ? "" : "\n\n") + exit_status_help());
    commands_.push_back(std::move(command));
}

void CommandLine::add_common_options(Parser& parser) {
    parser.add("--json", report_.json, "print the result, or the error, as JSON on standard output");
    parser.add("--quiet", report_.quiet, "print warnings and errors only");
    parser.add("--verbose", report_.verbose, "print warnings in full, not two lines of each");
}

ExitStatus CommandLine::run(int argument_count, char** arguments) {
    if (argument_count <= 1) {
        print_text("{}", program_.help());
        return ExitStatus::usage;
    }
    if (const auto page = program_.parse(argument_count, arguments)) {
        report_.json = false;  // the page is the result
        print_result(*page);
        return ExitStatus::done;
    }
    for (const Command& command : commands_)
        if (command.parser.is_chosen()) return command.run(report_);
    return ExitStatus::usage;
}

Command add_help(Parser& program) {
    const auto name = std::make_shared<std::string>();
    Parser parser = program.add_subcommand("help", "Print the help page of a subcommand");
    parser.add("SUBCOMMAND", *name, "the subcommand; without one, the page that lists them");
    parser.set_footer(
        "Examples:\n"
        "  clsdf help compute\n"
        "  clsdf help");
    return {parser, [program, name](Report&) {
                if (name->empty()) {
                    print_result(program.help());
                    return ExitStatus::done;
                }
                std::vector<std::string> names;
                for (const Parser& subcommand : program.subcommands()) {
                    names.push_back(subcommand.name());
                    if (names.back() != *name) continue;
                    print_result(subcommand.help());
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
    clsdf::tuning::read_environment();
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

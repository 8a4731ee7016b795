#include "second_compiler.hpp"

#include "command.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

namespace {

constexpr const char* subcommand = "compile-ahead";

/// Starts this program without a terminal. 0 if it cannot be started.
pid_t start(std::vector<std::string> arguments) {
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t process = 0;
    const int failure = posix_spawn(&process, "/proc/self/exe", &actions, nullptr, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    return failure == 0 ? process : 0;
}

void compile_level(const std::string& choice, const std::string& folder) {
    const clsdf::Device device = open_device(choice);
    device.read_programs("");
    device.write_programs(folder);
    clsdf::tuning::compile_level(device);
}

/// Builds those of this processor's level, too.
void check_levels(const clsdf::Device& device) {
    const std::vector<std::string> missing = clsdf::tuning::missing_programs(device);
    if (!missing.empty())
        throw clsdf::Error(clsdf::ErrorCode::unsupported, fmt::format("the bundled driver lacks {} programs: {}",
                                                                      missing.size(), fmt::join(missing, "; ")));
    clsdf::tuning::compile_level(device);
}

}  // namespace

SecondCompiler::SecondCompiler(const std::string& device, const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"clsdf", subcommand};
    if (!device.empty()) all.insert(all.end(), {"--device", device});
    all.insert(all.end(), arguments.begin(), arguments.end());
    process_ = start(std::move(all));
}

void SecondCompiler::wait(const std::stop_token& stop) {
    while (process_ != 0 && !stop.stop_requested()) {
        if (::waitpid(process_, nullptr, WNOHANG) != 0)
            process_ = 0;
        else
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

SecondCompiler::~SecondCompiler() {
    if (process_ == 0) return;
    // A compilation that is cut off leaves no file that counts.
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
}

std::vector<std::string> bricks_ahead(clsdf::OutputSet outputs) {
    std::vector<std::string> arguments;
    for (const clsdf::OutputInfo& output : extra_outputs())
        if (outputs.contains(output.output)) arguments.insert(arguments.end(), {"--with", output.name});
    return arguments;
}

Command add_compile_ahead(Parser& program) {
    struct Options {
        std::string device;
        std::vector<std::string> with;
        bool prepare = false;
        std::string programs;
        bool check = false;
    };
    const auto options = std::make_shared<Options>();
    Parser parser = program.add_subcommand(subcommand, "Compile programs beside another process that needs them");
    parser.hide();
    add_device_option(parser, options->device, "what computes");
    add_outputs_option(parser, options->with);
    parser.add("--prepare", options->prepare, "instead of the bricks: half of what \"clsdf devices --prepare\" does");
    parser.add("--programs", options->programs, "instead: write all programs of a bundled driver, for this level")
        .takes_text("FOLDER");
    parser.add("--check", options->check, "instead: tell which programs the bundled driver lacks");
    return {parser, [options](Report& report) {
                if (!options->programs.empty()) {
                    compile_level(options->device, options->programs);
                    return ExitStatus::done;
                }
                const clsdf::Device device = open_device(options->device);
                if (options->check)
                    check_levels(device);
                else if (!specialises_at_launch(device))
                    return ExitStatus::done;  // a driver that compiles nothing at a launch, such as the bundled one
                else if (options->prepare)
                    prepare_ahead(report, device);
                else
                    clsdf::tuning::compile_bricks(device, parse_outputs(options->with));
                return ExitStatus::done;
            }};
}

#include "second_compiler.hpp"

#include "option_values.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <thread>
#include <utility>

namespace {

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

}  // namespace

SecondCompiler::SecondCompiler(const std::string& device, const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"clsdf", compile_ahead};
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

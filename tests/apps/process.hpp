#pragma once

#include "support/temporary_folder.hpp"

#include <boost/test/unit_test.hpp>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace clsdf::test {

/// The command's path in the build; a bundle of programs on another machine overrides it.
inline std::string command_path() {
    const char* const path = std::getenv("CLSDF_COMMAND");
    return path == nullptr ? CLSDF_COMMAND : path;
}

/// The result of a process: its exit status (or minus the signal that ended it) and its output.
struct Outcome {
    int status = 0;
    std::string out;
    std::string error;
    double seconds = 0;
    std::size_t peak_bytes = 0;  ///< of memory that was resident at once
    double cpu_seconds = 0;      ///< of all its threads
};

/// The real command in a process of its own.
class Process {
public:
    /// `environment` is added to this process' own, as "NAME=value". `out` names a file for standard output, e.g.
    /// /dev/full. `prepare` runs in the new process, with its own standard streams, before the command does.
    explicit Process(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {},
                     const std::string& out = {}, const std::function<void()>& prepare = {})
        : out_(out.empty() ? folder_.file("out") : out), error_(folder_.file("error")) {
        id_ = ::fork();
        BOOST_REQUIRE(id_ >= 0);
        if (id_ == 0) execute(arguments, environment, prepare);
    }
    /// A process that nothing waited for, because its test failed, is killed.
    ~Process() {
        if (has_been_waited_for_) return;
        send(SIGKILL);
        reap();
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void send(int signal) const { ::kill(id_, signal); }

    std::string error_so_far() const { return content_of(error_); }

    /// Processor seconds of all its threads, from Linux; 0 when it has ended.
    double cpu_seconds_so_far() const {
        const std::string stat = content_of("/proc/" + std::to_string(id_) + "/stat");
        // After the name in brackets: the state, ten numbers, and the ticks of user and system.
        std::istringstream words(stat.substr(std::min(stat.rfind(')') + 1, stat.size())));
        std::string word;
        for (int i = 0; i < 11; ++i) words >> word;
        double user = 0, system = 0;
        words >> user >> system;
        return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
    }

    /// Waits until `predicate` returns true. The test ends if the process ends before, or after so many seconds.
    void wait_until(const std::function<bool()>& predicate, int seconds = 300) const {
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
        for (;; std::this_thread::sleep_for(std::chrono::milliseconds(2))) {
            const bool had_ended = has_ended(), is_late = std::chrono::steady_clock::now() > give_up;
            if (predicate()) return;
            BOOST_REQUIRE_MESSAGE(!had_ended, "the command ended too early and said: " << error_so_far());
            BOOST_REQUIRE_MESSAGE(!is_late, "waited " << seconds << " s; the command said: " << error_so_far());
        }
    }

    Outcome wait() {
        const auto [status, usage] = reap();
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
        const bool exited = WIFEXITED(status);
        const bool own_output = out_ == folder_.file("out");
        return {exited ? WEXITSTATUS(status) : -WTERMSIG(status),
                own_output ? content_of(out_) : std::string(),
                content_of(error_),
                elapsed.count(),
                static_cast<std::size_t>(usage.ru_maxrss) * 1024,
                seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime)};
    }

private:
    std::pair<int, struct rusage> reap() {
        std::pair<int, struct rusage> result{};
        while (::wait4(id_, &result.first, 0, &result.second) < 0 && errno == EINTR) {
        }
        has_been_waited_for_ = true;
        return result;
    }

    /// Leaves its status to be waited for.
    bool has_ended() const {
        siginfo_t info{};
        return ::waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != 0;
    }

    static double seconds_of(const struct timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }

    // The lists are this process' own copies, because exec takes pointers to what it could change.
    [[noreturn]] void execute(std::vector<std::string> arguments, std::vector<std::string> environment,
                              const std::function<void()>& prepare) const {
        arguments.insert(arguments.begin(), command_path());
        std::vector<char*> words;
        words.reserve(arguments.size() + 1);
        for (std::string& argument : arguments) words.push_back(argument.data());
        words.push_back(nullptr);
        for (std::string& variable : environment) ::putenv(variable.data());
        ::dup2(::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
        ::dup2(::open(error_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
        if (prepare) prepare();
        ::execv(words[0], words.data());
        ::_exit(127);
    }

    TemporaryFolder folder_;
    std::string out_;
    std::string error_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    pid_t id_ = -1;
    bool has_been_waited_for_ = false;
};

inline Outcome run_command(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {},
                           const std::string& out = {}) {
    return Process(arguments, environment, out).wait();
}

/// Checks the exit status, and that each fragment stands in the message.
inline void check_refused(const Outcome& outcome, int status, const std::vector<std::string>& fragments) {
    BOOST_TEST_CONTEXT("message: " << outcome.error) {
        BOOST_TEST(outcome.status == status);
        BOOST_TEST(outcome.out.empty());
        for (const std::string& fragment : fragments)
            BOOST_CHECK_MESSAGE(outcome.error.find(fragment) != std::string::npos, "no '" << fragment << "'");
    }
}

/// All texts that match the first group of a regular expression.
inline std::set<std::string> matches(const std::string& text, const std::string& pattern) {
    const std::regex expression(pattern);
    std::set<std::string> result;
    for (std::sregex_iterator match(text.begin(), text.end(), expression), end; match != end; ++match)
        result.insert((*match)[1]);
    return result;
}

/// The subcommands that the help page lists.
inline std::set<std::string> subcommands() {
    const std::string help = run_command({"--help"}).out;
    const std::size_t begin = help.find("Subcommands:\n");
    BOOST_REQUIRE(begin != std::string::npos);
    std::set<std::string> names = matches(help.substr(begin, help.find("\n\n", begin) - begin), "\n  ([a-z]+)");
    BOOST_REQUIRE(names.size() >= 11U);
    return names;
}

/// The exit status of the command for each code of an error.
inline const std::map<std::string, int> exit_statuses{
    {"invalid_argument", 2}, {"unsupported", 2},    {"unreadable_input", 3}, {"invalid_mesh", 3},   {"no_device", 4},
    {"out_of_memory", 4},    {"device_failure", 4}, {"wrong_results", 4},    {"output_failure", 5}, {"cancelled", 6}};

inline const std::string tetrahedron = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// Makes the loader of OpenCL look for devices in a folder that does not exist.
inline const std::vector<std::string> no_devices{"OCL_ICD_VENDORS=/nonexistent"};

}  // namespace clsdf::test

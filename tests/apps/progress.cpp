#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>

#include <poll.h>
#include <pty.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <regex>

using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;

namespace {

/// The command with a terminal of its own as standard error.
class OnTerminal {
public:
    /// `environment` is added to this process' own, as "NAME=value".
    explicit OnTerminal(std::vector<std::string> arguments, std::vector<std::string> environment = {}) {
        arguments.insert(arguments.begin(), clsdf::test::command_path());
        std::vector<char*> words;
        for (std::string& argument : arguments) words.push_back(argument.data());
        words.push_back(nullptr);
        id_ = ::forkpty(&terminal_, nullptr, nullptr, nullptr);
        BOOST_REQUIRE(id_ >= 0);
        if (id_ == 0) {
            for (std::string& variable : environment) ::putenv(variable.data());
            ::execv(words[0], words.data());
            ::_exit(127);
        }
    }
    ~OnTerminal() { ::close(terminal_); }
    OnTerminal(const OnTerminal&) = delete;
    OnTerminal& operator=(const OnTerminal&) = delete;

    /// Appends what is printed next; false if the command has ended, or has run for two minutes.
    bool read_more(std::string& text) const {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(give_up_ - std::chrono::steady_clock::now());
        pollfd readable{terminal_, POLLIN, 0};
        if (left.count() <= 0 || ::poll(&readable, 1, static_cast<int>(left.count())) != 1) return false;
        std::array<char, 4096> buffer{};
        const ssize_t count = ::read(terminal_, buffer.data(), buffer.size());
        if (count <= 0) return false;
        text.append(buffer.data(), static_cast<std::size_t>(count));
        return true;
    }

    /// As a user does it.
    void type_control_c() const { BOOST_REQUIRE(::write(terminal_, "\x03", 1) == 1); }

    int wait() const {
        int status = 0;
        ::waitpid(id_, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

private:
    std::chrono::steady_clock::time_point give_up_ = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    int terminal_ = -1;
    pid_t id_ = -1;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_terminal_shows_a_bar_with_the_time_left_until_control_c) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off");
    BOOST_REQUIRE(run_command({"shape", "sphere6", "-o", mesh}).status == 0);
    const OnTerminal terminal(
        {"compute", mesh, "-o", folder.file("field.npy"), "--resolution", "700", "--band", "full"});
    const std::regex bar(R"(\r\[#+ *\] +[0-9]+%  about [0-9]+ (s|min [0-9]+ s|h [0-9]+ min) left)");
    std::string text;
    bool interrupted = false;
    while (terminal.read_more(text)) {
        if (interrupted || !std::regex_search(text, bar)) continue;
        interrupted = true;
        terminal.type_control_c();
    }
    BOOST_TEST(interrupted, "no bar in " << text);
    BOOST_TEST(terminal.wait() == 6);
    BOOST_TEST(text.find("clsdf: cancelled; nothing was written") != std::string::npos);
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(a_terminal_shows_each_step_of_a_compilation) {
    const TemporaryFolder folder, caches;
    const OnTerminal terminal({"compute", folder.file("mesh.off", clsdf::test::tetrahedron), "-o",
                               folder.file("field.npy"), "--resolution", "16", "--band", "3v"},
                              {"CLSDF_CACHE_DIR=" + caches.file("own"), "POCL_CACHE_DIR=" + caches.file("pocl")});
    const std::regex compiling(R"(\rcompiling kernels [0-9]+ of [0-9]+)");
    std::string text;
    bool has_compiled = false;
    while (terminal.read_more(text)) {
        if (has_compiled || !std::regex_search(text, compiling)) continue;
        has_compiled = true;
        terminal.type_control_c();
    }
    BOOST_TEST(has_compiled, "no steps in " << text);
    BOOST_TEST(terminal.wait() == 6);
}

#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>

#include <pty.h>

#include <array>
#include <regex>

using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;

namespace {

/// The command with a terminal of its own as standard error.
class OnTerminal {
public:
    explicit OnTerminal(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), clsdf::test::command_path());
        std::vector<char*> words;
        for (std::string& argument : arguments) words.push_back(argument.data());
        words.push_back(nullptr);
        id_ = ::forkpty(&terminal_, nullptr, nullptr, nullptr);
        BOOST_REQUIRE(id_ >= 0);
        if (id_ == 0) {
            ::execv(words[0], words.data());
            ::_exit(127);
        }
    }
    ~OnTerminal() { ::close(terminal_); }
    OnTerminal(const OnTerminal&) = delete;
    OnTerminal& operator=(const OnTerminal&) = delete;

    /// Appends what is printed next; false if the command has ended.
    bool read_more(std::string& text) const {
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

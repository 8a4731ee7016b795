#include "interruption.hpp"

#include "report.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace {

// The end of the pipe that the handler writes to. A signal handler may use a pipe, but neither a stop source nor a
// mutex.
std::atomic<int> signal_pipe = -1;
std::atomic<int> signals = 0;
static_assert(std::atomic<int>::is_always_lock_free);
std::atomic<bool> is_written = false;

std::mutex mutex;
std::stop_source* active = nullptr;

// After this many signals the orderly end itself is stuck.
constexpr int most_signals = 3;

extern "C" void handle_signal(int) {
    const int error = errno;
    const char message = 0;
    if (++signals > most_signals || ::write(signal_pipe, &message, 1) != 1)
        ::_exit(static_cast<int>(ExitStatus::cancelled));
    errno = error;
}

// The signals that end the process: the known ones that were not ignored at the start. Set before any other thread
// starts.
constexpr std::array known_signals{SIGINT, SIGTERM, SIGHUP};
sigset_t ending_signals;

// The others are blocked, in all threads and child processes: the compilers of some devices put handlers of their own
// in the place of SIG_IGN, and these delete the file that is being compiled.
void choose_signals() {
    sigset_t ignored_signals;
    ::sigemptyset(&ending_signals);
    ::sigemptyset(&ignored_signals);
    for (const int signal : known_signals) {
        struct sigaction action {};
        ::sigaction(signal, nullptr, &action);
        // nohup ignores SIGHUP, and a shell's script ignores SIGINT for its background jobs.
        ::sigaddset(action.sa_handler == SIG_IGN ? &ignored_signals : &ending_signals, signal);
    }
    ::pthread_sigmask(SIG_BLOCK, &ignored_signals, nullptr);
}

void handle_signals_by(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    for (const int signal : known_signals)
        if (::sigismember(&ending_signals, signal) == 1) ::sigaction(signal, &action, nullptr);
}

// Whether an Interruption is alive and has not been stopped yet.
bool stop_what_runs() {
    const std::lock_guard lock(mutex);
    return active != nullptr && active->request_stop();
}

[[noreturn]] void end_now(bool json) {
    clsdf::abandon_unfinished_files();
    if (::isatty(STDERR_FILENO) != 0) print_text("\n");  // the terminal shows ^C, or a progress bar
    Report report;
    report.json = json;
    ::_exit(static_cast<int>(
        report.fail(clsdf::ErrorCode::cancelled,
                    is_written ? "cancelled; the output had been written already" : "cancelled; nothing was written")));
}

void listen(int pipe, bool json) {
    while (true) {
        char message = 0;
        if (::read(pipe, &message, 1) < 0) {
            if (errno == EINTR) continue;
            return;
        }
        if (!stop_what_runs()) end_now(json);
    }
}

bool errors_are_json = false;
std::atomic<bool> is_over = false;

// Among the last functions that run at the end.
void explain_exit() {
    if (is_over) return;
    clsdf::abandon_unfinished_files();
    Report report;
    report.json = errors_are_json;
    ::_exit(static_cast<int>(report.fail(
        clsdf::ErrorCode::device_failure,
        "a library has ended the program, most likely the compiler of the OpenCL driver, whose own message may stand "
        "above; it needs room for files in its cache and in /tmp. --device chooses another device")));
}

}  // namespace

void end_when_left_by_a_library(bool json) {
    errors_are_json = json;
    std::atexit(explain_exit);
}

void end_when_interrupted(bool json) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        throw clsdf::Error(clsdf::ErrorCode::out_of_memory, "no pipe can be opened to listen for Ctrl-C");
    signal_pipe = ends[1];
    // The thread inherits the mask of blocked signals, so the main thread gets them.
    choose_signals();
    sigset_t before;
    ::pthread_sigmask(SIG_BLOCK, &ending_signals, &before);
    std::thread([pipe = ends[0], json] { listen(pipe, json); }).detach();
    handle_signals_by(handle_signal);
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void output_is_written() {
    is_written = true;
}

void ignore_interruptions() {
    is_over = true;
    handle_signals_by(SIG_IGN);
}

bool interrupted() {
    return signals > 0;
}

Interruption::Interruption() {
    const std::lock_guard lock(mutex);
    active = &source_;
}

void Interruption::finish(const std::string& message) const {
    const std::lock_guard lock(mutex);
    active = nullptr;
    if (token().stop_requested()) throw clsdf::Error(clsdf::ErrorCode::cancelled, message);
}

Interruption::~Interruption() {
    const std::lock_guard lock(mutex);
    active = nullptr;
    handle_signals_by(handle_signal);  // the compilers of some devices have set their own handlers
}

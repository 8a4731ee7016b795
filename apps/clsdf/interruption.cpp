#include "interruption.hpp"

#include "exit_status.hpp"

#include <clsdf/error.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <atomic>
#include <cerrno>
#include <csignal>

namespace {

constexpr char interrupted = 'i';
constexpr char finished = 'f';

// The end of a pipe that the handler writes to, or -1. A stop source may not be touched by a signal handler; a pipe
// may.
std::atomic<int> signal_pipe = -1;
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void handle_signal(int) {
    const int error = errno;
    const int pipe = signal_pipe.exchange(-1);
    if (pipe < 0 || ::write(pipe, &interrupted, 1) != 1) ::_exit(static_cast<int>(ExitStatus::cancelled));
    errno = error;
}

}  // namespace

void end_when_interrupted() {
    struct sigaction action {};
    action.sa_handler = handle_signal;
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
}

Interruption::Interruption() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        throw clsdf::Error(clsdf::ErrorCode::out_of_memory, "no pipe can be opened to listen for Ctrl-C");
    read_end_ = ends[0];
    write_end_ = ends[1];
    listener_ = std::thread([this] {
        char message = 0;
        while (::read(read_end_, &message, 1) < 0 && errno == EINTR) {
        }
        if (message == interrupted) source_.request_stop();
    });
    signal_pipe = write_end_;
}

Interruption::~Interruption() {
    signal_pipe = -1;
    while (::write(write_end_, &finished, 1) < 0 && errno == EINTR) {
    }
    listener_.join();
    ::close(read_end_);
    ::close(write_end_);
}

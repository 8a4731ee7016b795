#include "scratch_watcher.hpp"

#include "core/stopwatch.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <mutex>

namespace {

using clsdf::Stopwatch;

std::atomic<bool> are_stopped = false;

extern "C" void wait_until_started(int) {
    const int error = errno;
    constexpr timespec moment{0, 500'000};
    while (are_stopped) ::nanosleep(&moment, nullptr);
    errno = error;
}

int stopping_signal() {
    return SIGRTMAX - 2;
}

/// Lets the other threads of the process wait in the handler of a signal while it lives. System calls go on
/// (SA_RESTART), or return EINTR as for any signal.
class StoppedThreads {
public:
    StoppedThreads() : tasks_(::opendir("/proc/self/task")) {
        // From the first stopped thread on nothing may be allocated: it may be within malloc.
        if (tasks_ == nullptr) return;
        are_stopped = true;
        const long own = ::syscall(SYS_gettid), process = ::getpid();
        while (const dirent* const task = ::readdir(tasks_))
            if (const long thread = std::strtol(task->d_name, nullptr, 10); thread > 0 && thread != own)
                ::syscall(SYS_tgkill, process, thread, stopping_signal());
    }
    ~StoppedThreads() {
        are_stopped = false;
        if (tasks_ != nullptr) ::closedir(tasks_);
    }
    StoppedThreads(const StoppedThreads&) = delete;
    StoppedThreads& operator=(const StoppedThreads&) = delete;

private:
    DIR* tasks_;
};

}  // namespace

ScratchWatcher::ScratchWatcher(std::size_t limit)
    : low_(limit / 16 * 12),
      high_(limit / 16 * 13),
      stopping_(limit / 16 * 14),
      most_queued_(limit / 8),
      statm_(::open("/proc/self/statm", O_RDONLY | O_CLOEXEC)) {
    total();
    struct sigaction action {};
    action.sa_handler = wait_until_started;
    action.sa_flags = SA_RESTART;
    ::sigfillset(&action.sa_mask);
    ::sigaction(stopping_signal(), &action, nullptr);
    // It gets no signals: others handle them.
    sigset_t all, before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] { run(); });
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

ScratchWatcher::~ScratchWatcher() {
    {
        const std::lock_guard lock(mutex_);
        is_over_ = true;
    }
    over_.notify_one();
    thread_.join();
}

void ScratchWatcher::run() {
    using std::chrono::milliseconds;
    constexpr milliseconds soon{1}, later{20}, much_later{100};
    for (milliseconds pause = later;;) {
        {
            std::unique_lock lock(mutex_);
            if (over_.wait_for(lock, pause, [this] { return is_over_; })) return;
        }
        const std::size_t resident = total();
        is_futile_ = resident > high_ && !keep_within_limit();
        pause = is_futile_ ? much_later : resident > low_ / 2 ? soon : later;
    }
}

std::size_t ScratchWatcher::total() {
    std::array<char, 128> text{};
    if (::pread(statm_.number(), text.data(), text.size() - 1, 0) <= 0) return 0;
    char* second = nullptr;  // the number of resident pages
    std::strtoull(text.data(), &second, 10);
    static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const std::size_t bytes = static_cast<std::size_t>(std::strtoull(second, nullptr, 10)) * page + queued_;
    most_resident_ = std::max(most_resident_.load(), bytes);
    return bytes;
}

bool ScratchWatcher::keep_within_limit() {
    if (ScratchBlocks::of_process().is_empty()) return false;
    for (std::size_t now = total(); now > low_; now = total()) {
        if (now > stopping_ && !is_futile_) {
            if (!free_with_all_stopped()) return false;
            continue;
        }
        const std::lock_guard lock(ScratchBlocks::of_process().mutex());
        if (!free_some()) return false;
    }
    return true;
}

bool ScratchWatcher::free_with_all_stopped() {
    const Stopwatch watch;
    // Before they stop: one of them may hold it.
    const std::lock_guard lock(ScratchBlocks::of_process().mutex());
    bool is_enough = false;
    {
        const StoppedThreads stopped;
        // Each piece is unmapped, and leaves.
        for (std::size_t left = 2 * ScratchBlocks::of_process().piece_count() + length_; left > 0; --left) {
            is_enough = total() <= high_;
            if (is_enough || !free_some()) break;
        }
    }
    stopped_seconds_ = stopped_seconds_ + watch.seconds();
    return is_enough;
}

bool ScratchWatcher::free_some() {
    ScratchBlocks& blocks = ScratchBlocks::of_process();
    Queued next;
    if (queued_ < most_queued_ && length_ < longest_queue && blocks.unmap_next(next.piece, next.resident)) {
        queue_[(first_ + length_++) % longest_queue] = next;
        queued_ += next.resident;
        return true;
    }
    if (length_ == 0) return false;
    const Queued& oldest = queue_[first_];
    blocks.evict(oldest.piece);
    queued_ -= oldest.resident;
    first_ = (first_ + 1) % longest_queue;
    --length_;
    return true;
}

#pragma once

#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>

/// Processor time of this process and of its threads.
namespace clsdf::test {

using Threads = std::set<pid_t>;

inline Threads all_threads() {
    Threads threads;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task"))
        threads.insert(std::stoi(entry.path().filename().string()));
    return threads;
}

/// 0 for a thread that has ended.
inline std::uint64_t nanoseconds_of(clockid_t clock) {
    timespec time{};
    if (::clock_gettime(clock, &time) != 0) return 0;
    return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(time.tv_nsec);
}

/// What threads take from the construction on. Those that are made and end in between count for process_ns() alone.
class ThreadTimes {
public:
    /// The driver's threads are those that work for it.
    explicit ThreadTimes(const Threads& of_driver) : of_driver_(of_driver) {
        for (const pid_t thread : all_threads()) before_[thread] = nanoseconds_of(clock_of(thread));
        process_before_ = nanoseconds_of(CLOCK_PROCESS_CPUTIME_ID);
    }

    /// Of the process without the driver's threads.
    std::uint64_t process_ns() const {
        std::uint64_t time = nanoseconds_of(CLOCK_PROCESS_CPUTIME_ID) - process_before_, of_driver = 0;
        for (const pid_t thread : of_driver_) of_driver += since(thread);
        return time > of_driver ? time - of_driver : 0;
    }

    /// Threads that have run beside the calling one and the driver's.
    std::size_t other_threads() const {
        std::size_t count = 0;
        for (const pid_t thread : all_threads())
            if (thread != ::gettid() && !of_driver_.contains(thread) && since(thread) > 0) ++count;
        return count;
    }

private:
    /// The number by which Linux knows the clock of a thread of this process.
    static clockid_t clock_of(pid_t thread) {
        constexpr unsigned processor_time_of_thread = 6;
        return static_cast<clockid_t>(~static_cast<unsigned>(thread) << 3U | processor_time_of_thread);
    }

    std::uint64_t since(pid_t thread) const {
        const auto known = before_.find(thread);
        const std::uint64_t now = nanoseconds_of(clock_of(thread)), before = known == before_.end() ? 0 : known->second;
        return now > before ? now - before : 0;
    }

    Threads of_driver_;
    std::map<pid_t, std::uint64_t> before_;
    std::uint64_t process_before_ = 0;
};

}  // namespace clsdf::test

#pragma once

#include <cstddef>
#include <string>

namespace clsdf::bench {

/// What a record of a measurement says of where it was made.
struct Machine {
    std::string processor;
    std::size_t threads = 0;       ///< that the measurement used
    std::size_t memory_bytes = 0;  ///< 0 where the system does not tell
    std::string system;            ///< "Debian GNU/Linux 12 (bookworm)"
};

/// `threads` 0: all there are.
Machine this_machine(std::size_t threads);

/// Threads of the library's host loops, of the peers, and of an OpenCL device on the processor (PoCL) from here on. To
/// be called before anything touches OpenCL.
class ThreadLimit {
public:
    explicit ThreadLimit(std::size_t threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    void* control_;
};

/// "2026-11-20 08:15 UTC".
std::string time_of_day();

}  // namespace clsdf::bench

#pragma once

#include <cstddef>
#include <string>

namespace clsdf::bench {

/// The machine of a measurement.
struct Machine {
    std::string processor;
    std::size_t threads = 0;       ///< used by the measurement
    std::size_t memory_bytes = 0;  ///< 0 if unknown
    std::string system;            ///< "Debian GNU/Linux 12 (bookworm)"
};

/// `threads` 0: all.
Machine this_machine(std::size_t threads);

/// Sets the threads of the library's host loops, of the peers, and of an OpenCL device on the processor (PoCL). Call it
/// before the first use of OpenCL.
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

#pragma once

#include <sys/resource.h>
#include <chrono>

namespace clsdf::bench {

/// Seconds by the clock on the wall, and of the processor: user and system time of all threads of this process.
struct Cost {
    double wall = 0;
    double processor = 0;
};

/// The cost since its construction.
class CostWatch {
public:
    Cost cost() const {
        return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(),
                processor_seconds() - processor_begin_};
    }

private:
    static double processor_seconds() {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        const auto seconds = [](const timeval& time) {
            return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
        };
        return seconds(usage.ru_utime) + seconds(usage.ru_stime);
    }

    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    double processor_begin_ = processor_seconds();
};

}  // namespace clsdf::bench

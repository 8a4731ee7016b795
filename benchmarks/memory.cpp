#include "benchmarks/memory.hpp"

#include <malloc.h>
#include <fstream>
#include <string>

namespace clsdf::bench {

namespace {

/// A line of /proc/self/status, "VmRSS:  1234 kB", in bytes.
std::optional<std::size_t> status_bytes(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        std::size_t kilobytes = 0;
        if (word == key && status >> kilobytes) return kilobytes * 1024;
    }
    return std::nullopt;
}

}  // namespace

PeakMemory::PeakMemory() {
    malloc_trim(0);  // freed memory that malloc keeps would hide a method's memory
    std::ofstream clear("/proc/self/clear_refs");
    clear << "5" << std::flush;
    if (clear) before_ = status_bytes("VmRSS:");
}

std::optional<std::size_t> PeakMemory::growth() const {
    const auto peak = status_bytes("VmHWM:");
    if (!before_ || !peak) return std::nullopt;
    return *peak > *before_ ? *peak - *before_ : 0;
}

}  // namespace clsdf::bench

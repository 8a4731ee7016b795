#include "benchmarks/machine.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <unistd.h>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <thread>

namespace clsdf::bench {

namespace {

/// The text after `key` and the separator on the first such line.
std::string value_in(const char* file_name, const std::string& key, char separator) {
    std::ifstream file(file_name);
    for (std::string line; std::getline(file, line);)
        if (line.starts_with(key)) {
            std::string value = line.substr(line.find(separator) + 1);
            for (const char blank : {' ', '"'})
                while (!value.empty() && value.front() == blank) value.erase(0, 1);
            while (!value.empty() && value.back() == '"') value.pop_back();
            return value;
        }
    return "unknown";
}

}  // namespace

Machine this_machine(std::size_t threads) {
    Machine machine;
    machine.processor = value_in("/proc/cpuinfo", "model name", ':');
    machine.threads = threads > 0 ? threads : std::thread::hardware_concurrency();
    machine.system = value_in("/etc/os-release", "PRETTY_NAME", '=');
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    if (pages > 0 && page > 0) machine.memory_bytes = static_cast<std::size_t>(pages) * static_cast<std::size_t>(page);
    return machine;
}

ThreadLimit::ThreadLimit(std::size_t threads)
    : control_(new tbb::global_control(tbb::global_control::max_allowed_parallelism, threads)) {
    const std::string count = std::to_string(threads);
    for (const char* variable : {"POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT"})
        setenv(variable, count.c_str(), 1);  // PoCL before and since 4.0
}

ThreadLimit::~ThreadLimit() {
    delete static_cast<tbb::global_control*>(control_);
}

std::string time_of_day() {
    return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
}

}  // namespace clsdf::bench

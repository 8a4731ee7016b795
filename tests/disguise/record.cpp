#include "disguise/record.hpp"

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <time.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <thread>

namespace clsdf::disguise {

namespace {

std::string variable(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? "" : value;
}

/// [CALL:]NUMBER[+] or kernel:NUMBER
Fault fault_of_environment() {
    Fault fault;
    std::string text = variable("CLSDF_DISGUISE_FAULT");
    if (text.empty()) return fault;
    if (text.back() == '+') {
        fault.onwards = true;
        text.pop_back();
    }
    const std::size_t colon = text.find(':');
    if (colon != std::string::npos) fault.call = text.substr(0, colon);
    fault.in_kernel = fault.call == "kernel";
    if (fault.in_kernel) fault.call = "clEnqueueNDRangeKernel";
    fault.number = std::strtoull(text.c_str() + (colon == std::string::npos ? 0 : colon + 1), nullptr, 10);
    if (const std::string code = variable("CLSDF_DISGUISE_CODE"); !code.empty()) fault.code = std::stoi(code);
    return fault;
}

/// A GPU of Intel, as far as it tells its maker.
Answers gpu_of_intel(const std::string& name) {
    constexpr unsigned intel = 0x8086;
    return {{{CL_DEVICE_NAME, name}}, {{CL_DEVICE_TYPE, CL_DEVICE_TYPE_GPU}, {CL_DEVICE_VENDOR_ID, intel}}};
}

Record* record_of_environment() {
    auto* const record = new Record;
    record->settings.gpu = variable("CLSDF_DISGUISE") == "gpu";
    record->settings.pocl_3_0 = variable("CLSDF_DISGUISE") == "pocl-3.0";
    record->settings.without_platforms = variable("CLSDF_DISGUISE_PLATFORMS") == "0";
    record->settings.compute_units =
        static_cast<unsigned>(std::strtoul(variable("CLSDF_DISGUISE_UNITS").c_str(), nullptr, 10));
    if (const std::string name = variable("CLSDF_DISGUISE_INTEL"); !name.empty())
        record->settings.devices = {gpu_of_intel(name)};
    const std::string external = variable("CLSDF_DISGUISE_EXTERNAL");
    record->settings.external_memory = !external.empty();
    record->settings.unshared_semaphores = external == "memory+unshared-semaphores";
    record->settings.external_semaphores = external == "memory+semaphores" || record->settings.unshared_semaphores;
    record->fault = fault_of_environment();
    return record;
}

/// One write, so that the lines of processes that end together do not mix.
[[gnu::destructor]] void append_counts() {
    const std::string path = variable("CLSDF_DISGUISE_COUNTS");
    if (path.empty()) return;
    const Counts all = counts();
    if (all.all_calls == 0) return;  // a compiler that the driver has started
    const std::string line = to_json(all) + '\n';
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (file < 0) return;
    if (::write(file, line.data(), line.size()) < 0) errno = 0;
    ::close(file);
}

}  // namespace

namespace {

/// The host's time on a thread. Calls may be nested: one in a callback, say.
struct HostTime {
    int depth = 0;
    std::uint64_t since = 0;  ///< when the latest call returned
};
thread_local HostTime host_time;
std::atomic<std::thread::id> timed_thread{};

std::uint64_t processor_time() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(time.tv_nsec);
}

/// The least of a few: what a look at the clock takes, from within.
std::uint64_t cost_of_clock() {
    static const std::uint64_t cost = [] {
        std::uint64_t least = UINT64_MAX;
        for (int i = 0; i < 100; ++i) {
            const std::uint64_t begin = processor_time();
            least = std::min(least, processor_time() - begin);
        }
        return least;
    }();
    return cost;
}

bool is_timed() {
    return timed_thread.load(std::memory_order_relaxed) == std::this_thread::get_id();
}

void add_host_time() {
    const std::uint64_t time = processor_time() - host_time.since, cost = cost_of_clock();
    count([&](Counts& counts) { counts.host_ns += time > cost ? time - cost : 0; });
}

}  // namespace

InCall::InCall() {
    if (host_time.depth++ == 0 && is_timed()) add_host_time();
}

InCall::~InCall() {
    if (--host_time.depth == 0 && is_timed()) host_time.since = processor_time();
}

bool is_in_call() {
    return host_time.depth > 0;
}

void time_host() {
    cost_of_clock();
    timed_thread = std::this_thread::get_id();
    host_time.since = processor_time();
}

void end_host_time() {
    if (is_timed()) add_host_time();
    timed_thread = std::thread::id();
}

Record& record() {
    static Record* const only = record_of_environment();
    return *only;
}

cl_int begin(const char* call, cl_int* status) {
    Record& all = record();
    const std::scoped_lock lock(all.mutex);
    const std::uint64_t of_name = ++all.counts.calls[call];
    const std::uint64_t of_all = ++all.counts.all_calls;
    const Fault& fault = all.fault;
    if (fault.number == 0 || (!fault.call.empty() && fault.call != call)) return CL_SUCCESS;
    const std::uint64_t number = fault.call.empty() ? of_all : of_name;
    if (number != fault.number && !(fault.onwards && number > fault.number)) return CL_SUCCESS;
    if (fault.in_kernel) {
        if (status != nullptr) *status = fault.code;
        return CL_SUCCESS;
    }
    if (all.counts.failed.empty()) all.counts.failed = call;
    return fault.code;
}

void count_memory(std::int64_t more) {
    Record& all = record();
    const std::scoped_lock lock(all.mutex);
    all.bytes += static_cast<std::uint64_t>(more);
    all.counts.peak_bytes = std::max(all.counts.peak_bytes, all.bytes);
}

void count_launch(const std::string& kernel, std::uint64_t work_items) {
    Record& all = record();
    const std::scoped_lock lock(all.mutex);
    KernelCounts& of_kernel = all.counts.kernels[kernel];
    if (all.latest_kernel != kernel) ++of_kernel.runs;
    all.latest_kernel = kernel;
    ++all.counts.launches;
    ++all.counts.commands;
    ++of_kernel.launches;
    of_kernel.work_items += work_items;
}

void set(const Settings& settings) {
    const std::scoped_lock lock(record().mutex);
    record().settings = settings;
}

Counts counts() {
    const std::scoped_lock lock(record().mutex);
    return record().counts;
}

void restart(const Fault& fault) {
    end_late_releases();
    const std::scoped_lock lock(record().mutex);
    record().fault = fault;
    record().counts = {};
    record().counts.peak_bytes = record().bytes;
    record().latest_kernel.clear();
}

std::string to_json(const Counts& counts) {
    nlohmann::ordered_json json;
    json["bytes_up"] = counts.bytes_up;
    json["bytes_down"] = counts.bytes_down;
    json["pageable_bytes"] = counts.pageable_bytes;
    json["transfers_up"] = counts.transfers_up;
    json["transfers_down"] = counts.transfers_down;
    json["blocking_waits"] = counts.blocking_waits;
    json["pinned_reads"] = counts.pinned_reads;
    json["commands"] = counts.commands;
    json["launches"] = counts.launches;
    json["fills"] = counts.fills;
    json["copies"] = counts.copies;
    json["allocations"] = counts.allocations;
    json["first_uses"] = counts.first_uses;
    json["allocated_bytes"] = counts.allocated_bytes;
    json["peak_bytes"] = counts.peak_bytes;
    json["programs_built"] = counts.programs_built;
    if (counts.host_ns > 0) json["host_ns"] = counts.host_ns;
    json["all_calls"] = counts.all_calls;
    if (!counts.failed.empty()) json["failed"] = counts.failed;
    json["calls"] = counts.calls;
    for (const auto& [name, kernel] : counts.kernels)
        json["kernels"][name] = {
            {"launches", kernel.launches}, {"runs", kernel.runs}, {"work_items", kernel.work_items}};
    return json.dump();
}

}  // namespace clsdf::disguise

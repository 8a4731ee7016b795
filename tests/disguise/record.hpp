#pragma once

#include "disguise/disguise.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>

/// Shared by the files that wrap OpenCL's calls.
namespace clsdf::disguise {

/// The function with this name in the loader of OpenCL. An extension of Python has a loader that only it sees.
inline void* next_function(const char* name) {
    if (void* const found = ::dlsym(RTLD_NEXT, name)) return found;
    void* const loader = ::dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
    return loader == nullptr ? nullptr : ::dlsym(loader, name);
}
#define CLSDF_NEXT(name)                                                                         \
    ([] {                                                                                        \
        static auto* const next_one = reinterpret_cast<decltype(&::name)>(next_function(#name)); \
        return next_one;                                                                         \
    }())

struct Record {
    std::mutex mutex;
    Settings settings;
    Fault fault;
    Counts counts;
    std::uint64_t bytes = 0;  ///< of buffers, now
    std::string latest_kernel;
};
/// Never destroyed: the driver's threads may outlive it.
Record& record();

/// The time of a call of OpenCL, which is not the host's: made first in each function that takes the place of one.
class InCall {
public:
    InCall();
    InCall(const InCall&) = delete;
    InCall& operator=(const InCall&) = delete;
    ~InCall();
};

/// Counts a call. Returns the code that it is to fail with, or CL_SUCCESS. status: that of its kernel, if this is to
/// fail in its place.
cl_int begin(const char* call, cl_int* status = nullptr);

/// change(counts), one thread at a time.
template <class Change>
void count(Change&& change) {
    const std::scoped_lock lock(record().mutex);
    change(record().counts);
}

inline void count_wait() {
    count([](Counts& counts) { ++counts.blocking_waits; });
}

inline void count_command() {
    count([](Counts& counts) { ++counts.commands; });
}

inline void count_up(std::uint64_t bytes) {
    count([&](Counts& counts) {
        ++counts.transfers_up;
        counts.bytes_up += bytes;
    });
}

inline void count_down(std::uint64_t bytes) {
    count([&](Counts& counts) {
        ++counts.transfers_down;
        counts.bytes_down += bytes;
    });
}

/// Buffers have so many bytes more, or fewer.
void count_memory(std::int64_t more);

/// Calls the functions that Settings::ends_late has put off.
void end_late_releases();

void count_launch(const std::string& kernel, std::uint64_t work_items);

/// For a call that gives an object and has failed.
inline std::nullptr_t refused(cl_int code, cl_int* error) {
    if (error != nullptr) *error = code;
    return nullptr;
}

}  // namespace clsdf::disguise

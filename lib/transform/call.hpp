#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>

#include "device/context.hpp"

#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace clsdf::transform {

/// The functions of a call's options. If one of them throws, the call ends: it does not try again with less memory,
/// even if the error is out_of_memory.
class Caller {
public:
    explicit Caller(const CallOptions& options) : options_(options) {}

    const CallOptions& options() const { return options_; }
    /// Whether there is something to call between launches.
    bool is_watching() const { return options_.progress || options_.should_stop; }

    /// Throws Error(cancelled) if the caller wants the call to stop.
    void throw_if_stopped();
    /// Of the samples or points.
    void progress(double fraction);
    void report(const Progress& progress);
    void warn(const std::string& message);

    /// Whether the error means that the call needs more memory than there is.
    bool is_short_of_memory(const Error& error) const {
        return error.code() == ErrorCode::out_of_memory && !has_thrown_;
    }

private:
    template <typename Function, typename... Arguments>
    auto pass_on(const Function& function, const Arguments&... arguments);

    const CallOptions& options_;
    bool has_thrown_ = false;
};

/// A mutex that detects a second lock() by the same thread: a function of CallOptions uses the transform that called
/// it. Then lock() throws Error(invalid_argument); it would wait for ever.
class CallMutex {
public:
    void lock();
    void unlock();
    /// Throws if this thread has locked it.
    void check_thread() const;

private:
    std::mutex mutex_;
    std::atomic<std::thread::id> owner_{};
};

/// The building, loading and testing of programs by one call.
class Compiling {
public:
    explicit Compiling(Caller& caller) : caller_(caller) {}

    /// `variant_steps`: those of building beside the programs that all computations need.
    device::BuildWatch watch(std::size_t variant_steps);

    double seconds = 0;
    bool first_use = false;

private:
    Caller& caller_;
    std::size_t step_ = 0;
};

}  // namespace clsdf::transform

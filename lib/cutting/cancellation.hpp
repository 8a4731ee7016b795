#pragma once

#include <clsdf/error.hpp>

#include <functional>
#include <string>
#include <thread>

namespace clsdf::cutting {

/// Asks should_stop in loops on all cores, on the calling thread alone.
class Cancellation {
public:
    /// what: for the message, as "the search for the outer surface".
    Cancellation(const std::function<bool()>& should_stop, const char* what) : should_stop_(should_stop), what_(what) {}

    /// Throws Error(cancelled) if the caller says so.
    void check() const {
        if (should_stop_ && is_callers_thread() && should_stop_())
            throw Error(ErrorCode::cancelled, std::string(what_) + " was cancelled");
    }

    bool is_callers_thread() const { return std::this_thread::get_id() == thread_; }

private:
    const std::function<bool()>& should_stop_;
    const char* what_;
    std::thread::id thread_ = std::this_thread::get_id();
};

}  // namespace clsdf::cutting

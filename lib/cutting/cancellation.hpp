#pragma once

#include <clsdf/error.hpp>

#include <functional>
#include <thread>

namespace clsdf::cutting {

/// Asks should_stop in loops on all cores, on the calling thread alone.
class Cancellation {
public:
    explicit Cancellation(const std::function<bool()>& should_stop) : should_stop_(should_stop) {}

    /// Throws Error(cancelled) if the caller says so.
    void check() const {
        if (should_stop_ && std::this_thread::get_id() == thread_ && should_stop_())
            throw Error(ErrorCode::cancelled, "the search for the outer surface was cancelled");
    }

private:
    const std::function<bool()>& should_stop_;
    std::thread::id thread_ = std::this_thread::get_id();
};

}  // namespace clsdf::cutting

#pragma once

#include <clsdf/error.hpp>

#include "core/refuse.hpp"

#include <atomic>
#include <mutex>
#include <thread>

namespace clsdf {

/// A mutex that is held while functions of CallOptions run. It detects a second lock() by the same thread: such a
/// function uses what is locked. Then lock() throws Error(invalid_argument); it would wait for ever.
class CallMutex {
public:
    /// locked: what must not be used, for the message.
    explicit CallMutex(const char* locked) : locked_(locked) {}

    void lock() {
        check_thread();
        mutex_.lock();
        owner_ = std::this_thread::get_id();
    }
    void unlock() {
        owner_ = std::thread::id();
        mutex_.unlock();
    }
    /// Throws if this thread has locked it.
    void check_thread() const {
        if (owner_.load() == std::this_thread::get_id())
            refuse("a function of a call's options used {}; use it when the call has returned", locked_);
    }

private:
    std::mutex mutex_;
    std::atomic<std::thread::id> owner_{};
    const char* locked_;
};

}  // namespace clsdf

#pragma once

#include "core/lifetime.hpp"
#include "device/context.hpp"

#include <utility>

namespace clsdf::device {

/// Memory of the host that commands read or write between begin() and end(). If it is destroyed in between, after an
/// error, it waits for the queue. If the driver cannot tell that the commands have ended, the memory lives as long as
/// the process. As the last member of an object it is destroyed first: it waits before the others are destroyed.
///
/// Commands may still use memory when an error ends a call. So each kind of memory has one owner:
/// - Buffers: BufferPool::Lease gives them to later commands only, and to none if the device is lost.
/// - The host's memory under a buffer: buffer_in() keeps it as long as the driver has the buffer.
/// - Arrays of a call that are copied, or written in place: InFlight, SlabPipeline.
/// - The caller's memory: Context::run_or_drain() waits before the call returns.
template <class Value>
class InFlight {
public:
    explicit InFlight(const Context& context, Value value = {}) : context_(context), value_(std::move(value)) {}
    InFlight(const InFlight&) = delete;
    InFlight& operator=(const InFlight&) = delete;
    ~InFlight() {
        if (is_under_way_ && !context_.drain()) keep_for_good(value_);
    }

    Value& operator*() { return value_; }
    const Value& operator*() const { return value_; }
    Value* operator->() { return &value_; }
    const Value* operator->() const { return &value_; }

    void begin() { is_under_way_ = true; }
    void end() { is_under_way_ = false; }

private:
    const Context& context_;
    Value value_;
    bool is_under_way_ = false;
};

}  // namespace clsdf::device

#pragma once

#include "core/lifetime.hpp"
#include "device/context.hpp"
#include "device/opencl.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace clsdf::device {

/// A few values that commands of the context's queue read from the device, in pinned memory if there is some. As
/// InFlight: if it is destroyed before end(), it waits for the queue, and if the driver cannot tell that the commands
/// have ended, the memory lives as long as the process.
template <class Value>
class ReadBack {
    static_assert(std::is_trivially_copyable_v<Value>);

public:
    explicit ReadBack(const Context& context, std::size_t count = 1)
        : context_(context), count_(count), room_(context.take_room(bytes())) {
        if (room_ == nullptr) own_ = std::make_unique<Value[]>(count_);
    }
    ReadBack(const ReadBack&) = delete;
    ReadBack& operator=(const ReadBack&) = delete;
    ~ReadBack() {
        const bool have_ended = !is_under_way_ || context_.drain();
        if (room_ != nullptr && have_ended) context_.give_back_room(room_, bytes());
        if (own_ && !have_ended) keep_for_good(own_);
    }

    /// Enqueues the read of all values, from byte `begin` of the buffer on. Throws cl::Error.
    void enqueue(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin = 0,
                 cl::Event* is_read = nullptr) {
        is_under_way_ = true;
        queue.enqueueReadBuffer(from, CL_FALSE, begin, bytes(), data(), nullptr, is_read);
    }
    /// The commands have ended.
    void end() { is_under_way_ = false; }

    std::span<const Value> values() const { return {data(), count_}; }
    const Value& value() const { return values()[0]; }

private:
    std::size_t bytes() const { return count_ * sizeof(Value); }
    Value* data() const { return room_ != nullptr ? reinterpret_cast<Value*>(room_) : own_.get(); }

    const Context& context_;
    std::size_t count_;
    std::byte* room_;
    std::unique_ptr<Value[]> own_;
    bool is_under_way_ = false;
};

/// Reads a value from byte `begin` of a buffer, behind all commands in the context's queue. Waits. Throws cl::Error,
/// also if a kernel has failed.
template <class Value>
Value read_value(const Context& context, const cl::Buffer& from, std::size_t begin = 0) {
    ReadBack<Value> read(context);
    cl::Event is_read;  // a blocking read by PoCL does not fail if a kernel has
    read.enqueue(context.queue(), from, begin, &is_read);
    is_read.wait();
    read.end();
    return read.value();
}

/// The same for all values of an array.
template <class Values>
void read_values(const Context& context, const cl::Buffer& from, Values& to, std::size_t begin = 0) {
    context.read(context.queue(), from, begin, to.size() * sizeof(to[0]), reinterpret_cast<std::byte*>(to.data()));
}

}  // namespace clsdf::device

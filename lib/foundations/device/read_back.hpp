#pragma once

#include "core/lifetime.hpp"
#include "device/context.hpp"
#include "device/opencl.hpp"

#include <cstddef>
#include <iterator>
#include <memory>
#include <span>
#include <type_traits>

namespace clsdf::device {

/// A few values that commands of the context's queue read from the device, in pinned memory if there is some. As
/// InFlight: if it is destroyed before wait() or end(), it waits for the queue, and if the driver cannot tell that the
/// commands have ended, the memory lives as long as the process.
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
    void enqueue(const cl::Buffer& from, std::size_t begin = 0) {
        is_under_way_ = true;
        launched_ = context_.kernels().launched().count();
        context_.queue().enqueueReadBuffer(from, CL_FALSE, begin, bytes(), data(), nullptr, &is_read_);
    }
    /// Waits for the values. Throws as Context::wait().
    void wait() {
        context_.wait(is_read_, launched_);
        end();
    }
    /// The commands have ended: the host has waited for a later one.
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
    cl::Event is_read_;
    std::size_t launched_ = 0;  // before the read
    bool is_under_way_ = false;
};

/// Reads a value from byte `begin` of a buffer, behind all commands in the context's queue. Throws as Context::wait().
template <class Value>
Value read_value(const Context& context, const cl::Buffer& from, std::size_t begin = 0) {
    ReadBack<Value> read(context);
    read.enqueue(from, begin);
    read.wait();
    return read.value();
}

/// The same for all values of an array.
template <class Values>
void read_values(const Context& context, const cl::Buffer& from, Values& to, std::size_t begin = 0) {
    context.read(context.queue(), from, begin, to.size() * sizeof(to[0]), reinterpret_cast<std::byte*>(to.data()));
}

/// Writes values to a buffer, behind all commands in the context's queue. Throws as Context::wait().
template <class Values>
void write_values(const Context& context, const Values& values, const cl::Buffer& to, std::size_t begin = 0) {
    context.run_blocking([&](cl::Event* ended) {
        context.queue().enqueueWriteBuffer(to, CL_TRUE, begin, std::size(values) * sizeof(values[0]), std::data(values),
                                           nullptr, ended);
    });
}

}  // namespace clsdf::device

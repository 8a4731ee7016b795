#pragma once

#include <clsdf/calls.hpp>

#include "device/buffer_pool.hpp"

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf::engine {

/// The input of a kept value, which is out of date when it changes.
enum class MadeOf { caller, triangles, positions };

enum class UsedBy { grids, points, both };

/// A value that a transform keeps of its mesh, or nothing if it is not made yet.
class KeptValue {
public:
    KeptValue(MadeOf made_of_in, UsedBy used_by_in) : made_of(made_of_in), used_by(used_by_in) {}
    virtual ~KeptValue() = default;

    virtual KeptMemory memory() const = 0;
    /// Whether somebody else holds what it has on the device, or a part of it.
    virtual bool is_in_use() const = 0;
    /// Gives up a value that is out of date.
    virtual void forget() = 0;
    /// Whether what it has on the device could be made again.
    virtual bool can_leave_device() const { return true; }
    /// Gives up what it has on the device, if that could be made again. Neither allocates nor reads.
    virtual void leave_device() = 0;

    MadeOf made_of;
    UsedBy used_by;
};

/// In order of priority: if memory is short, the first values are kept. A value comes after those whose memory it
/// holds.
using KeptValues = std::vector<KeptValue*>;

/// The memory that a value takes by its own account; none if it gives no account.
template <class T>
KeptMemory memory_of(const T* value) {
    KeptMemory memory;
    if (value == nullptr) return memory;
    if constexpr (requires { value->host_bytes(); }) memory.host_bytes = value->host_bytes();
    if constexpr (requires { value->device_bytes(); }) memory.device_bytes = value->device_bytes();
    if constexpr (std::is_same_v<T, device::BufferPool::Lease>) memory.device_bytes = value->bytes();
    return memory;
}

/// A value that has one form. It can be made again.
template <class T>
class Kept final : public KeptValue {
public:
    /// all: the list that this is added to; it must not be used any more when this is destroyed.
    Kept(KeptValues& all, MadeOf made_of_in, UsedBy used_by_in = UsedBy::grids) : KeptValue(made_of_in, used_by_in) {
        all.push_back(this);
    }
    Kept(const Kept&) = delete;
    Kept& operator=(const Kept&) = delete;

    /// Null if there is no value.
    const std::shared_ptr<const T>& get() const { return value_; }
    explicit operator bool() const { return value_ != nullptr; }
    const T& operator*() const { return *value_; }
    const T* operator->() const { return value_.get(); }

    void set(std::shared_ptr<const T> value) { value_ = std::move(value); }
    /// The value, which is what make() returns if there was none.
    template <class Make>
    const std::shared_ptr<const T>& get_or(const Make& make) {
        if (!value_) value_ = std::make_shared<const T>(make());
        return value_;
    }

    KeptMemory memory() const override { return memory_of(value_.get()); }
    bool is_in_use() const override { return value_.use_count() > 1; }
    void forget() override { value_.reset(); }
    void leave_device() override {
        if (memory().device_bytes > 0) value_.reset();
    }

private:
    std::shared_ptr<const T> value_;
};

}  // namespace clsdf::engine

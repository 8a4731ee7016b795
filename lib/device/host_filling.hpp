#pragma once

#include "device/buffer_pool.hpp"

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace clsdf::device {

/// Few values that kernels read, copied at once: to write them to a buffer of the pool would wait for all that was
/// enqueued before. There must be one at least.
template <class Value>
cl::Buffer copied(const Context& context, const std::vector<Value>& values) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): it is read only
    auto* const data = const_cast<Value*>(values.data());
    return guarded([&] {
        return cl::Buffer(context.context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(Value),
                          data);
    });
}

/// A buffer that the host fills: in place, as on a processor, whose memory is the host's, or by way of an array that is
/// copied at the end.
class HostFilling {
public:
    HostFilling(const Context& context, std::shared_ptr<BufferPool> pool, std::size_t bytes, const char* purpose)
        : HostFilling(context, std::move(pool), bytes, purpose, context.capabilities().is_processor) {}
    HostFilling(const Context& context, std::shared_ptr<BufferPool> pool, std::size_t bytes, const char* purpose,
                bool in_place);
    HostFilling(const HostFilling&) = delete;
    HostFilling& operator=(const HostFilling&) = delete;
    ~HostFilling();

    /// `bytes` bytes, their contents undefined; what has been written can be read.
    void* memory() const { return memory_; }

    /// Hands the filled buffer over. A buffer that is not filled in place is leased only now: of several fillings of
    /// which all but the last are given up one is on the device. Does not wait: the array is kept until it is copied.
    /// Nothing may be written to the memory any more.
    BufferPool::Lease finish();

private:
    void unmap();

    const Context& context_;
    std::shared_ptr<BufferPool> pool_;
    std::size_t bytes_;
    const char* purpose_;
    BufferPool::Lease buffer_;  // where it is mapped
    void* memory_ = nullptr;
    bool is_mapped_ = false;
    std::unique_ptr<std::byte[]> array_;  // where the buffer is not mapped
};

}  // namespace clsdf::device

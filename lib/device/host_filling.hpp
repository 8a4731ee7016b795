#pragma once

#include "device/buffer_pool.hpp"

#include <cstddef>
#include <memory>
#include <utility>

namespace clsdf::device {

/// A buffer that the host fills: in place, as on a processor, whose memory is the host's, or by way of an array that is
/// copied at the end.
class HostFilling {
public:
    HostFilling(Context& context, BufferPool::Lease buffer, std::size_t bytes)
        : HostFilling(context, std::move(buffer), bytes, context.capabilities().is_processor) {}
    HostFilling(Context& context, BufferPool::Lease buffer, std::size_t bytes, bool in_place);
    HostFilling(const HostFilling&) = delete;
    HostFilling& operator=(const HostFilling&) = delete;
    ~HostFilling();

    /// `bytes` bytes, their contents undefined; what has been written can be read.
    void* memory() const { return memory_; }

    /// Hands the filled buffer over; nothing may be written to the memory any more.
    BufferPool::Lease finish();

private:
    void unmap();

    Context& context_;
    BufferPool::Lease buffer_;
    std::size_t bytes_;
    void* memory_ = nullptr;
    bool is_mapped_ = false;
    std::unique_ptr<std::byte[]> array_;  // where the buffer is not mapped
};

}  // namespace clsdf::device

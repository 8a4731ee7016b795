#pragma once

#include "device/buffer_pool.hpp"

namespace clsdf::transform {

/// Exclusive prefix sums of `count` 32-bit values into starts[0, count], enqueued when it is made: what else the host
/// waits for can be enqueued before it waits.
class PrefixSums {
public:
    /// Throws Error(out_of_memory), naming `what`, where there are 2^32 values or more.
    PrefixSums(device::Context& context, const cl::Program& program, const std::shared_ptr<device::BufferPool>& pool,
               const cl::Buffer& values, const cl::Buffer& starts, std::size_t count, const char* what);

    PrefixSums(const PrefixSums&) = delete;
    PrefixSums& operator=(const PrefixSums&) = delete;
    ~PrefixSums();

    /// Of all values; blocks. Throws Error(out_of_memory), naming `what`, where it exceeds 32 bits.
    std::size_t total() const;

private:
    const char* what_;
    device::BufferPool::Lease sums_;
    cl_ulong total_ = 0;
    cl::Event total_read_;
};

}  // namespace clsdf::transform

#pragma once

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "launch/launches.hpp"

#include <cstddef>

namespace clsdf::engine {

/// The memory of a sort, for so many keys.
struct SortMemory {
    /// Throws Error(out_of_memory).
    SortMemory(device::BufferPool& pool, std::size_t count);

    device::BufferPool::Lease counts, totals, keys, order;

    std::size_t device_bytes() const { return counts.bytes() + totals.bytes() + keys.bytes() + order.bytes(); }
};

/// Writes the indices [0, count) to `order` by ascending keys; equal keys keep their order. keys: of 32 bits, less than
/// 2^bits; the buffer holds nothing afterwards. Does not wait. Throws Error(out_of_memory).
void sort_by_keys(const DeviceTools& tools, const cl::Buffer& keys, std::size_t count, unsigned bits,
                  const cl::Buffer& order);
/// The same in memory that is at hand. Throws cl::Error.
void sort_by_keys(const Launches& launches, const Programs& programs, const SortMemory& memory, const cl::Buffer& keys,
                  std::size_t count, unsigned bits, const cl::Buffer& order);

}  // namespace clsdf::engine

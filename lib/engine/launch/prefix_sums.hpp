#pragma once

#include <clsdf/error.hpp>

#include "device/buffer_pool.hpp"
#include "device/in_flight.hpp"
#include "launch/device_tools.hpp"

#include <cstddef>
#include <memory>

namespace clsdf::engine {

/// For lists of `what` that 32 bits cannot count.
Error too_many(const char* what);

/// Exclusive prefix sums of `count` 32-bit values into starts[0, count), and their total into starts[count].
class PrefixSums {
public:
    /// Enqueues the sums and does not wait: what else the host must know can be asked for before it waits for all.
    /// Throws Error(out_of_memory), naming `what`, if the values are too many to be counted in 32 bits.
    PrefixSums(const DeviceTools& tools, const cl::Buffer& values, const cl::Buffer& starts, std::size_t count,
               const char* what);

    /// The sum of all values; waits for it. Throws Error(out_of_memory), naming `what`, if it exceeds 32 bits, so that
    /// the starts are wrong.
    std::size_t total();

private:
    const char* what_;
    device::BufferPool::Lease sums_;
    cl::Event total_read_;
    device::InFlight<std::unique_ptr<cl_ulong>> total_;
};

}  // namespace clsdf::engine

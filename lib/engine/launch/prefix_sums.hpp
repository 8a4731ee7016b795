#pragma once

#include <clsdf/error.hpp>

#include "device/buffer_pool.hpp"
#include "device/in_flight.hpp"
#include "launch/commands.hpp"

#include <cstddef>
#include <memory>

namespace clsdf::scan {

struct Programs;

/// For lists of `what` that 32 bits cannot count.
Error too_many(const char* what);

/// Exclusive prefix sums of `count` 32-bit values into starts[0, count), and their total into starts[count].
class PrefixSums {
public:
    /// Throws Error(out_of_memory), naming `what`, if the values are too many to be counted in 32 bits.
    PrefixSums(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
               const cl::Buffer& values, const cl::Buffer& starts, std::size_t count, const char* what);

    /// Does not wait: what else the host must know can be asked for before it waits for all.
    void enqueue();

    /// The sum of all values; waits for it. Throws Error(out_of_memory), naming `what`, if it exceeds 32 bits, so that
    /// the starts are wrong.
    std::size_t total();

private:
    const char* what_;
    cl::CommandQueue queue_;
    bool is_few_;
    std::size_t parts_;    ///< 0 if the values are few
    WorkItems one_part_;   ///< of a launch that scans the parts' sums
    WorkItems all_parts_;  ///< of the others
    device::BufferPool::Lease sums_;
    cl::Kernel sum_kernel_;
    cl::Kernel offset_kernel_;
    cl::Kernel write_kernel_;
    cl::Event total_read_;
    device::InFlight<std::unique_ptr<cl_ulong>> total_;
};

}  // namespace clsdf::scan

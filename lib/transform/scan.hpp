#pragma once

#include "device/buffer_pool.hpp"

namespace clsdf::transform {

/// Exclusive prefix sums of `count` 32-bit values into starts[0, count]; blocks for the total.
/// Throws Error(out_of_memory), naming `what`, where the total exceeds 32 bits.
std::size_t scan(device::Context& context, const cl::Program& program, const std::shared_ptr<device::BufferPool>& pool,
                 const cl::Buffer& values, const cl::Buffer& starts, std::size_t count, const char* what);

}  // namespace clsdf::transform

#pragma once

#include "launch/device_tools.hpp"

#include <cstddef>

namespace clsdf::engine {

/// Writes the indices [0, count) to `order` by ascending keys; equal keys keep their order. keys: of 32 bits, less than
/// 2^bits; the buffer holds nothing afterwards. For the body by_group. Does not wait. Throws Error(out_of_memory).
void sort_by_keys(const DeviceTools& tools, const cl::Buffer& keys, std::size_t count, unsigned bits,
                  const cl::Buffer& order);

}  // namespace clsdf::engine

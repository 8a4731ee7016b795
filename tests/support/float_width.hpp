#pragma once

#include "support/exact_field.hpp"

#include "device/context.hpp"

namespace clsdf::test {

/// The tests' device, if its vectors had so many floats.
inline Device with_float_width(unsigned width) {
    const device::Context& own = device::context_of(test_device());
    const cl::CommandQueue queue(own.context(), own.device());
    Device device = Device::from_handles(own.context()(), own.device()(), queue());
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): no other processor is at hand
    const_cast<device::Context::Capabilities&>(device::context_of(device).capabilities()).float_width = width;
    return device;
}

}  // namespace clsdf::test

#pragma once

#include "device/context.hpp"

namespace clsdf::transform {

/// The kernels' programs for one device. Kernel objects are made anew for every use: they hold arguments, and are not
/// shared between threads.
struct Programs {
    cl::Program scan;
    cl::Program coarse_lists;
    cl::Program sign_sweep;
    cl::Program fill;

    explicit Programs(device::Context& context);

    /// The brick kernel is compiled for what is asked of it.
    cl::Program bricks(device::Context& context, bool with_triangle, bool count) const;
};

/// How many work-items share a job that is divided in ranges.
std::size_t parallel_parts(const device::Context& context);

}  // namespace clsdf::transform

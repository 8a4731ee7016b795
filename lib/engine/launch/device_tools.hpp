#pragma once

#include "device/buffer_pool.hpp"
#include "device/context.hpp"

#include <memory>

namespace clsdf::engine {

struct Programs;

/// The things that every stage on the device needs: its context, the pool that buffers come from, and the programs. All
/// of them must outlive it.
struct DeviceTools {
    device::Context& context;
    const std::shared_ptr<device::BufferPool>& pool;
    const Programs& programs;

    const cl::CommandQueue& queue() const { return context.queue(); }
    /// A kernel for a while. Throws cl::Error.
    device::LentKernel kernel(const cl::Program& program, const char* name) const {
        return {context.kernels(), program, name};
    }
};

}  // namespace clsdf::engine

#pragma once

#include <clsdf/outputs.hpp>

#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "finish/finishing.hpp"
#include "launch/device_tools.hpp"
#include "launch/launches.hpp"
#include "targets/output_targets.hpp"

#include <cstddef>

namespace clsdf::points {

/// Memory for packed outputs of points whose targets kernels cannot write to directly: they have strides, or are not
/// aligned. A kernel copies the values to the targets.
class PackedOutputs {
public:
    /// Memory for the outputs of so many points, of any type. Throws Error(out_of_memory).
    void make_room(device::BufferPool& pool, OutputSet outputs, std::size_t count);
    /// The same for those that cannot be written directly.
    void make_room(device::BufferPool& pool, const targets::DeviceTargets& targets, std::size_t count);

    /// Where kernels write the outputs.
    engine::OutputBuffers buffers_for(const targets::DeviceTargets& targets) const;
    /// Enqueues the copies to the targets, if there are any.
    void enqueue_copies(const engine::Launches& launches, const engine::DeviceTools& tools,
                        const targets::DeviceTargets& targets, std::size_t count) const;

    std::size_t device_bytes() const;

private:
    PerOutput<device::BufferPool::Lease> values_;
};

}  // namespace clsdf::points

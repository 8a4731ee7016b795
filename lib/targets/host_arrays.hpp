#pragma once

#include <clsdf/field.hpp>

#include "core/large_memory.hpp"
#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "finish/finishing.hpp"

#include <cstddef>
#include <vector>

namespace clsdf::targets {

/// A packed array of one output on the host.
struct HostArray {
    bool is_wanted = false;  ///< the output is asked for
    bool in_double = false;
    std::byte* data = nullptr;
    bool is_pinned = false;  ///< the memory: see OutputArray
};

using HostArrays = PerOutput<HostArray>;

/// Without memory yet, with the types of output_table().
HostArrays arrays_for(OutputSet outputs);
/// The arrays from a sample on.
HostArrays arrays_from(std::size_t sample, const HostArrays& arrays);
/// Bytes that one sample has in the largest of the wanted arrays.
std::size_t widest_of(const HostArrays& arrays);
FieldSlab slab_of(const HostArrays& arrays, std::size_t samples);

/// Device memory for the wanted arrays of a slab or of points: the arrays themselves on a processor, whose memory they
/// are.
struct OutputMemories {
    void place(const device::Context& context, device::BufferPool& pool, const HostArrays& wanted, std::size_t count);

    /// To be called after the commands that compute the result. If the arrays are the device's memory, they hold the
    /// result when the queue, which is in order, has finished.
    void enqueue_handover(const cl::CommandQueue& queue) const;
    /// On other devices: reads the finished result into the arrays.
    void read(const device::Context& context, const cl::CommandQueue& transfers) const;
    /// The same while they are computed; the milestones' ends are counted in samples.
    void read(const device::Context& context, const cl::CommandQueue& transfers,
              std::vector<device::Milestone> milestones) const;

    HostArrays arrays;
    std::size_t samples = 0;
    engine::OutputBuffers buffers;  ///< to which the device writes the samples
    PerOutput<device::BufferPool::Lease> leases;
    bool in_place = false;
};

/// Packed arrays of the library's own for outputs.
class OwnArrays {
public:
    /// Memory for the wanted outputs of so many samples, its contents undefined. Throws Error(out_of_memory).
    HostArrays for_samples(const HostArrays& wanted, std::size_t samples);
    /// Takes new memory from there if there is some, until it is given back.
    void borrow_from(device::SpareArrays& spares) { spares_ = &spares; }
    /// Gives the memory to later calls. Nothing writes to it any more.
    void give_back() noexcept;

    std::size_t bytes() const;

private:
    PerOutput<device::LinesOfMemory> arrays_;
    device::SpareArrays* spares_ = nullptr;
};

}  // namespace clsdf::targets

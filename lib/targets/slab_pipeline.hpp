#pragma once

#include <clsdf/calls.hpp>

#include "core/large_memory.hpp"
#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "finish/finishing.hpp"

#include <array>
#include <atomic>
#include <future>
#include <memory>

namespace clsdf::targets {

/// A packed array of one output on the host.
struct HostArray {
    bool is_wanted = false;  ///< the output is asked for
    bool in_double = false;
    std::byte* data = nullptr;
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

    HostArrays arrays;
    std::size_t samples = 0;
    engine::OutputBuffers buffers;  ///< to which the device writes the samples
    PerOutput<device::BufferPool::Lease> leases;
    bool in_place = false;
};

/// Elements of arrays of bytes, so many at once that making them costs nothing where compilers do not optimise.
struct MemoryLine {
    std::byte bytes[64];
};

/// Packed arrays of the library's own for outputs.
class OwnArrays {
public:
    /// Memory for the wanted outputs of so many samples, its contents undefined. Throws Error(out_of_memory).
    HostArrays for_samples(const HostArrays& wanted, std::size_t samples);

    std::size_t bytes() const;

private:
    PerOutput<UninitializedVector<MemoryLine>> arrays_;
};

/// Blocks of samples on their way from the device: while one is computed, the one before is read and handed on. Two
/// sets of buffers, a queue of its own for what is read, and a thread that reads and hands on, one block at a time, in
/// their order.
class SlabPipeline {
public:
    struct Slot {
        OutputMemories memories;  ///< to which the device writes the samples
        OwnArrays own;
        std::shared_future<void> delivered;
    };
    using HandOn = std::function<void(const HostArrays& values)>;

    /// Without overlap, deliver() reads and hands on itself.
    SlabPipeline(const device::Context& context, bool overlap);
    /// Blocks that were not handed on yet are dropped; waits for the thread.
    ~SlabPipeline();
    SlabPipeline(const SlabPipeline&) = delete;
    SlabPipeline& operator=(const SlabPipeline&) = delete;

    /// Waits until the slot's former samples have been handed on; throws what hand_on() threw.
    Slot& next();
    /// Releases the memory of a slot whose samples have not been computed. next() gives the slot again.
    void discard(Slot& slot);
    /// The samples have been computed. hand_on: empty if they stay where they are.
    void deliver(Slot& slot, HandOn hand_on);
    /// Waits for all; throws what hand_on() threw.
    void finish();

    /// Bytes of its own arrays on the host.
    std::size_t host_bytes() const;

private:
    const device::Context& context_;
    std::launch policy_;
    cl::CommandQueue transfers_;
    std::array<Slot, 2> slots_;
    std::size_t next_slot_ = 0;
    std::shared_future<void> latest_;
    std::atomic<bool> abandoned_ = false;
    bool is_finished_ = false;
};

}  // namespace clsdf::targets

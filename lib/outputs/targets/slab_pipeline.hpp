#pragma once

#include <clsdf/distance_transform.hpp>

#include "core/large_memory.hpp"
#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "prepare/finishing.hpp"

#include <array>
#include <atomic>
#include <future>
#include <memory>

namespace clsdf::scan {

/// A packed array of one output on the host.
struct HostArray {
    bool is_wanted = false;  ///< the output is asked for
    bool in_double = false;
    std::byte* data = nullptr;

    HostArray from_sample(const OutputInfo& row, std::size_t sample) const {
        return {is_wanted, in_double, data == nullptr ? nullptr : data + sample * sample_bytes(row, in_double)};
    }
};

using HostArrays = PerOutput<HostArray>;

/// Without memory yet, with the types of output_table().
HostArrays arrays_for(OutputSet outputs);
/// Bytes that one sample has in the largest of the wanted arrays.
std::size_t widest_of(const HostArrays& arrays);
FieldSlab slab_of(const HostArrays& arrays, std::size_t samples);

/// Device memory for the wanted arrays of a slab or of points: the arrays themselves on a processor, whose memory it
/// is.
class OutputMemories {
public:
    void place(const device::Context& context, device::BufferPool& pool, const HostArrays& arrays, std::size_t samples);

    const HostArrays& arrays() const { return arrays_; }
    /// The buffers to which the device writes the samples.
    OutputBuffers buffers() const;
    /// To be called after the commands that compute the samples. Arrays that are the device's memory hold them when
    /// the queue, which is in order, has finished.
    void enqueue_handover(const cl::CommandQueue& queue) const;
    /// On other devices: reads the finished samples into the arrays.
    void read(const device::Context& context, const cl::CommandQueue& transfers) const;

private:
    struct Memory {
        std::size_t bytes = 0;
        cl::Buffer in_place{};
        device::BufferPool::Lease lease{};
    };

    HostArrays arrays_;
    PerOutput<Memory> memory_;
};

/// Called with the slabs of a field, as SlabSink is.
using ArraySink = std::function<void(const Grid& part, const HostArrays& values)>;

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

/// Slabs on their way from the device: while one is computed, the one before is read and handed on. Two sets of
/// buffers, a queue of its own for what is read, and a thread that reads and calls the sink, with one slab at a time,
/// in their order.
class SlabPipeline {
public:
    class Slot {
    public:
        /// The memory to which the device writes the slab.
        const OutputMemories& memories() const { return memories_; }

    private:
        friend SlabPipeline;
        OutputMemories memories_;
        OwnArrays own_;
        std::shared_future<void> delivered_;
    };

    /// Without a sink, slabs stay in the caller's memory. Without overlap, the thread of deliver() calls the sink, and
    /// finish() reads the remaining slabs.
    SlabPipeline(const device::Context& context, std::shared_ptr<device::BufferPool> pool, ArraySink sink,
                 bool overlap);
    /// Slabs that were not handed on yet are dropped; waits for the sink.
    ~SlabPipeline();
    SlabPipeline(const SlabPipeline&) = delete;
    SlabPipeline& operator=(const SlabPipeline&) = delete;

    /// Waits until the slot's former slab has been handed on; throws what the sink threw.
    Slot& next();
    /// Memory of the device, for the caller's arrays.
    void place(Slot& slot, const Grid& slab, const HostArrays& callers);
    /// The same for arrays of the slot, of the wanted outputs.
    void place_own(Slot& slot, const Grid& slab, const HostArrays& wanted);
    /// The slot's slab has not been computed; next() gives the slot again.
    void take_back(Slot& slot);
    /// The slab has been computed.
    void deliver(Slot& slot, const Grid& slab);
    /// Waits for all; throws what the sink threw.
    void finish();

    /// Bytes of its own arrays on the host.
    std::size_t host_bytes() const;

private:
    const device::Context& context_;
    std::shared_ptr<device::BufferPool> pool_;
    ArraySink sink_;
    std::launch policy_;
    cl::CommandQueue transfers_;
    std::array<Slot, 2> slots_;
    std::size_t next_slot_ = 0;
    std::shared_future<void> latest_;
    std::atomic<bool> abandoned_ = false;
    bool is_finished_ = false;
};

}  // namespace clsdf::scan

#pragma once

#include <clsdf/distance_transform.hpp>

#include "device/buffer_pool.hpp"

#include <array>
#include <atomic>
#include <future>
#include <memory>

namespace clsdf::transform {

/// Device memory for a host array: the array itself on a processor, whose memory it is.
class OutputMemory {
public:
    void place(const device::Context& context, device::BufferPool& pool, void* host, std::size_t bytes);

    const cl::Buffer& buffer() const { return in_place_() != nullptr ? in_place_ : *lease_; }

    /// Enqueued behind what computes the result: where the array is the device's memory, it holds the result when all
    /// of the queue, which is in order, has ended.
    void enqueue_handover(const cl::CommandQueue& queue) const;
    /// Elsewhere: reads the result, which has been computed. The array holds it when the event has completed; null
    /// where there is nothing to read.
    cl::Event fetch(const cl::CommandQueue& transfers) const;

private:
    void* host_ = nullptr;
    std::size_t bytes_ = 0;
    cl::Buffer in_place_;
    device::BufferPool::Lease lease_;
};

/// Slabs on their way from the device: while one is computed, the one before is read and handed on. Two sets of
/// buffers, a queue of its own for what is read, and a thread for the sink, which is called with one slab at a time, in
/// their order.
class SlabPipeline {
public:
    struct Slot {
        HostOutputs host;
        OutputMemory distance;
        OutputMemory triangle;

    private:
        friend SlabPipeline;
        FieldArray<float> own_distance_;
        FieldArray<std::uint32_t> own_triangle_;
        std::shared_future<void> delivered_;
    };

    /// Without a sink slabs end in the caller's memory. Without overlap it is called from the thread of deliver().
    SlabPipeline(const device::Context& context, std::shared_ptr<device::BufferPool> pool, SlabSink sink, bool overlap);
    /// Slabs that were not handed on yet are dropped; waits for the sink.
    ~SlabPipeline();
    SlabPipeline(const SlabPipeline&) = delete;
    SlabPipeline& operator=(const SlabPipeline&) = delete;

    /// Waits until the slot's former slab has been handed on; throws what the sink threw.
    Slot& next();
    /// Memory of the device, for the caller's arrays; without these, for arrays of the slot.
    void place(Slot& slot, const Grid& slab, const Outputs& outputs, const HostOutputs& callers);
    /// The slot's slab has not been computed; next() gives the slot again.
    void take_back(Slot& slot);
    /// The slab has been computed.
    void deliver(Slot& slot, const Grid& slab);
    /// Waits for all; throws what the sink threw.
    void finish();

    /// What its own arrays take on the host.
    std::size_t host_bytes() const;

private:
    const device::Context& context_;
    std::shared_ptr<device::BufferPool> pool_;
    SlabSink sink_;
    std::launch policy_;
    cl::CommandQueue transfers_;
    std::array<Slot, 2> slots_;
    std::size_t turn_ = 0;
    std::shared_future<void> latest_;
    std::atomic<bool> abandoned_ = false;
    bool is_finished_ = false;
};

}  // namespace clsdf::transform

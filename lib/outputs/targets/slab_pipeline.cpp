#include "targets/slab_pipeline.hpp"

#include "core/lifetime.hpp"
#include "core/parallel.hpp"

#include <fmt/format.h>

namespace clsdf::scan {

namespace {

/// For exactly so many bytes if it must grow; what it holds is of no use any more.
void make_room(UninitializedVector<MemoryLine>& array, std::size_t bytes) {
    const std::size_t lines = chunk_count(bytes, sizeof(MemoryLine));
    if (array.capacity() < lines) array = {};
    array.resize(lines);
}

}  // namespace

HostArrays arrays_for(OutputSet outputs) {
    HostArrays arrays;
    for (const OutputInfo& info : infos_of(outputs))
        arrays[info.output] = {true, info.type == ElementType::float64, nullptr};
    return arrays;
}

std::size_t widest_of(const HostArrays& arrays) {
    std::size_t widest = 0;
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array) {
            if (array.is_wanted) widest = std::max(widest, sample_bytes(row, array.in_double));
        },
        arrays);
    return widest;
}

FieldSlab slab_of(const HostArrays& arrays, std::size_t samples) {
    FieldSlab slab;
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array) {
            if (array.is_wanted)
                slab.set(row.output, std::span<const std::byte>(array.data, samples * row.sample_bytes()));
        },
        arrays);
    return slab;
}

void OutputMemories::place(const device::Context& context, device::BufferPool& pool, const HostArrays& arrays,
                           std::size_t samples) {
    arrays_ = arrays;
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array, Memory& memory) {
            if (!array.is_wanted) return;
            memory.bytes = samples * sample_bytes(row, array.in_double);
            if (context.capabilities().is_processor) {
                memory.in_place =
                    cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, memory.bytes, array.data);
            } else if (memory.lease.bytes() < memory.bytes) {
                memory.lease = {};
                memory.lease = pool.lease(memory.bytes, "samples of the field");
            }
        },
        arrays_, memory_);
}

OutputBuffers OutputMemories::buffers() const {
    OutputBuffers buffers;
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array, const Memory& memory, cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            buffer = memory.in_place() != nullptr ? memory.in_place : *memory.lease;
            if (array.in_double) buffers.in_double |= bit_of(row);
        },
        arrays_, memory_, buffers);
    return buffers;
}

void OutputMemories::enqueue_handover(const cl::CommandQueue& queue) const {
    for_each_output(
        [&](const OutputInfo&, const HostArray& array, const Memory& memory) {
            if (!array.is_wanted || memory.in_place() == nullptr) return;
            void* mapped = queue.enqueueMapBuffer(memory.in_place, CL_FALSE, CL_MAP_READ, 0, memory.bytes);
            queue.enqueueUnmapMemObject(memory.in_place, mapped);
        },
        arrays_, memory_);
}

void OutputMemories::read(const device::Context& context, const cl::CommandQueue& transfers) const {
    for_each_output(
        [&](const OutputInfo&, const HostArray& array, const Memory& memory) {
            if (array.is_wanted && memory.in_place() == nullptr)
                context.read(transfers, *memory.lease, memory.bytes, array.data);
        },
        arrays_, memory_);
}

HostArrays OwnArrays::for_samples(const HostArrays& wanted, std::size_t samples) {
    HostArrays result = wanted;
    try {
        for_each_output(
            [&](const OutputInfo& row, HostArray& array, UninitializedVector<MemoryLine>& own) {
                make_room(own, array.is_wanted ? samples * sample_bytes(row, array.in_double) : 0);
                if (array.is_wanted) array.data = own.data()->bytes;
            },
            result, arrays_);
    } catch (const std::exception&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("the outputs of {} samples do not fit the memory; compute fewer at a time", samples));
    }
    return result;
}

std::size_t OwnArrays::bytes() const {
    std::size_t bytes = 0;
    for_each_output([&](const OutputInfo&,
                        const UninitializedVector<MemoryLine>& own) { bytes += own.capacity() * sizeof(MemoryLine); },
                    arrays_);
    return bytes;
}

SlabPipeline::SlabPipeline(const device::Context& context, std::shared_ptr<device::BufferPool> pool, ArraySink sink,
                           bool overlap)
    : context_(context),
      pool_(std::move(pool)),
      sink_(std::move(sink)),
      // A thread if one can be started, and if the sink or the transfer can overlap.
      policy_(overlap && (sink_ || !context.capabilities().is_processor) ? std::launch::async | std::launch::deferred
                                                                         : std::launch::deferred),
      transfers_(device::guarded([&] { return cl::CommandQueue(context.context(), context.device()); })) {}

SlabPipeline::~SlabPipeline() {
    if (is_finished_) return;
    abandoned_ = true;
    const bool is_read = clFinish(transfers_()) == CL_SUCCESS;
    if (latest_.valid()) latest_.wait();
    if (!is_read || context_.is_lost()) keep_for_good(slots_);
}

SlabPipeline::Slot& SlabPipeline::next() {
    // A sink that is not called meanwhile leaves the slot free.
    const bool alternates = !sink_ || policy_ != std::launch::deferred;
    Slot& slot = slots_[alternates ? next_slot_++ % slots_.size() : 0];
    if (slot.delivered_.valid()) slot.delivered_.get();
    return slot;
}

void SlabPipeline::place(Slot& slot, const Grid& slab, const HostArrays& callers) {
    device::guarded([&] { slot.memories_.place(context_, *pool_, callers, slab.sample_count()); });
}

void SlabPipeline::place_own(Slot& slot, const Grid& slab, const HostArrays& wanted) {
    place(slot, slab, slot.own_.for_samples(wanted, slab.sample_count()));
}

void SlabPipeline::take_back(Slot& slot) {
    slot = {};
    if (next_slot_ > 0) --next_slot_;
}

void SlabPipeline::deliver(Slot& slot, const Grid& slab) {
    is_finished_ = false;
    slot.delivered_ = std::async(policy_, [this, previous = latest_, &slot, slab]() mutable {
        if (!abandoned_) device::guarded([&] { slot.memories_.read(context_, transfers_); });
        if (previous.valid()) previous.get();
        previous = {};  // or the chain of all slabs would stay
        if (sink_ && !abandoned_) sink_(slab, slot.memories_.arrays());
    });
    latest_ = slot.delivered_;
    if (sink_ && policy_ == std::launch::deferred) latest_.get();
}

void SlabPipeline::finish() {
    if (latest_.valid()) latest_.get();
    is_finished_ = true;
}

std::size_t SlabPipeline::host_bytes() const {
    std::size_t bytes = 0;
    for (const Slot& slot : slots_) bytes += slot.own_.bytes();
    return bytes;
}

}  // namespace clsdf::scan

#include "transform/slab_pipeline.hpp"

#include "core/keep.hpp"

#include <fmt/format.h>

#include <vector>

namespace clsdf::transform {

namespace {

/// For exactly so many samples where it must grow; what it holds is of no use any more.
template <typename Value>
void make_room(FieldArray<Value>& array, std::size_t samples) {
    if (array.capacity() < samples) array = {};
    array.resize(samples);
}

}  // namespace

void OutputMemory::place(const device::Context& context, device::BufferPool& pool, void* host, std::size_t bytes) {
    host_ = host;
    bytes_ = bytes;
    if (context.capabilities().is_processor) {
        in_place_ = cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, host);
    } else if (lease_.bytes() < bytes) {
        lease_ = {};
        lease_ = pool.lease(bytes, "samples of the field");
    }
}

void OutputMemory::enqueue_handover(const cl::CommandQueue& queue) const {
    if (in_place_() == nullptr) return;
    void* mapped = queue.enqueueMapBuffer(in_place_, CL_FALSE, CL_MAP_READ, 0, bytes_);
    queue.enqueueUnmapMemObject(in_place_, mapped);
}

cl::Event OutputMemory::fetch(const cl::CommandQueue& transfers) const {
    cl::Event event;
    if (in_place_() == nullptr) {
        transfers.enqueueReadBuffer(*lease_, CL_FALSE, 0, bytes_, host_, nullptr, &event);
        transfers.flush();
    }
    return event;
}

SlabPipeline::SlabPipeline(const device::Context& context, std::shared_ptr<device::BufferPool> pool, SlabSink sink,
                           bool overlap)
    : context_(context),
      pool_(std::move(pool)),
      sink_(std::move(sink)),
      // A thread where there is one to be had, and where it is of use.
      policy_(sink_ && overlap ? std::launch::async | std::launch::deferred : std::launch::deferred),
      transfers_(device::guarded([&] { return cl::CommandQueue(context.context(), context.device()); })) {}

SlabPipeline::~SlabPipeline() {
    if (is_finished_) return;
    abandoned_ = true;
    const bool is_read = clFinish(transfers_()) == CL_SUCCESS;
    if (latest_.valid()) latest_.wait();
    if (!is_read || context_.is_lost()) keep_for_good(slots_);
}

SlabPipeline::Slot& SlabPipeline::next() {
    Slot& slot = slots_[turn_++ % slots_.size()];
    if (slot.delivered_.valid()) slot.delivered_.get();
    return slot;
}

void SlabPipeline::place(Slot& slot, const Grid& slab, const Outputs& outputs, const HostOutputs& callers) {
    const std::size_t samples = slab.sample_count();
    slot.host = callers;
    if (callers.distance.empty()) {
        try {
            make_room(slot.own_distance_, samples);
            make_room(slot.own_triangle_, outputs.triangle ? samples : 0);
        } catch (const std::exception&) {
            throw Error(ErrorCode::out_of_memory, fmt::format("a slab of {} x {} x {} samples does not fit the memory",
                                                              slab.size[0], slab.size[1], slab.size[2]));
        }
        slot.host = {slot.own_distance_, slot.own_triangle_};
    }
    device::guarded([&] {
        slot.distance.place(context_, *pool_, slot.host.distance.data(), samples * sizeof(float));
        if (outputs.triangle)
            slot.triangle.place(context_, *pool_, slot.host.triangle.data(), samples * sizeof(std::uint32_t));
    });
}

void SlabPipeline::take_back(Slot& slot) {
    slot = {};
    --turn_;
}

void SlabPipeline::deliver(Slot& slot, const Grid& slab) {
    is_finished_ = false;
    std::vector<cl::Event> read;
    device::guarded([&] {
        read.push_back(slot.distance.fetch(transfers_));
        if (!slot.host.triangle.empty()) read.push_back(slot.triangle.fetch(transfers_));
    });
    const FieldSlab values{slot.host.distance, slot.host.triangle};
    slot.delivered_ = std::async(policy_, [this, previous = latest_, read, slab, values]() mutable {
        if (previous.valid()) previous.get();
        previous = {};  // or the chain of all slabs would stay
        device::guarded([&] {
            for (const cl::Event& event : read)
                if (event() != nullptr) event.wait();
        });
        if (sink_ && !abandoned_) sink_(slab, values);
    });
    latest_ = slot.delivered_;
    if (sink_ && policy_ == std::launch::deferred) latest_.get();
}

void SlabPipeline::finish() {
    if (latest_.valid()) latest_.get();
    is_finished_ = true;
}

std::size_t SlabPipeline::host_bytes() const {
    std::size_t values = 0;
    for (const Slot& slot : slots_) values += slot.own_distance_.capacity() + slot.own_triangle_.capacity();
    return values * sizeof(float);
}

}  // namespace clsdf::transform

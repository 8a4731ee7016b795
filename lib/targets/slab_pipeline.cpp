#include "targets/slab_pipeline.hpp"

#include "core/lifetime.hpp"

#include <utility>

namespace clsdf::targets {

SlabPipeline::SlabPipeline(const device::Context& context, bool overlap)
    : context_(context),
      // A thread if one can be started.
      policy_(overlap ? std::launch::async | std::launch::deferred : std::launch::deferred),
      transfers_(device::guarded(
          [&] { return overlap ? cl::CommandQueue(context.context(), context.device()) : context.queue(); })) {
    for (Slot& slot : slots_) slot.own.borrow_from(context.spare_arrays());
}

SlabPipeline::~SlabPipeline() {
    if (is_finished_) {
        for (Slot& slot : slots_) slot.own.give_back();
        return;
    }
    abandoned_ = true;
    const bool is_read = clFinish(transfers_()) == CL_SUCCESS;
    if (latest_.valid()) latest_.wait();
    if (!is_read || context_.is_lost()) keep_for_good(slots_);
}

SlabPipeline::Slot& SlabPipeline::next() {
    // Without a thread the first slot is always free.
    Slot& slot = slots_[policy_ != std::launch::deferred ? next_slot_++ % slots_.size() : 0];
    if (slot.delivered.valid()) slot.delivered.get();
    return slot;
}

void SlabPipeline::discard(Slot& slot) {
    slot = {};
    slot.own.borrow_from(context_.spare_arrays());
    if (next_slot_ > 0) --next_slot_;
}

void SlabPipeline::deliver(Slot& slot, HandOn hand_on) {
    is_finished_ = false;
    slot.delivered = std::async(policy_, [this, previous = latest_, &slot, hand_on = std::move(hand_on)]() mutable {
        if (!abandoned_ && !slot.is_read) device::guarded([&] { slot.results().read(context_, transfers_); });
        if (previous.valid()) previous.get();
        previous = {};  // or the chain of all slabs would stay
        if (hand_on && !abandoned_) hand_on(slot.results().arrays);
    });
    latest_ = slot.delivered;
    if (policy_ == std::launch::deferred) latest_.get();
}

void SlabPipeline::finish() {
    if (latest_.valid()) latest_.get();
    is_finished_ = true;
}

std::size_t SlabPipeline::host_bytes() const {
    std::size_t bytes = 0;
    for (const Slot& slot : slots_) bytes += slot.own.bytes();
    return bytes;
}

}  // namespace clsdf::targets

#pragma once

#include "targets/host_arrays.hpp"

#include <array>
#include <atomic>
#include <functional>
#include <future>

namespace clsdf::targets {

/// Slabs on their way from the device: while one is computed, the one before is read and handed on. Two sets of
/// buffers, a queue of its own for what is read, and a thread that reads and hands on, one slab at a time, in their
/// order.
class SlabPipeline {
public:
    struct Slot {
        OutputMemories memories;  ///< to which the device writes the samples
        OutputMemories gathered;  ///< those of them that are wanted, if they are few
        bool is_gathered = false;
        bool is_read = false;  ///< the results are in their arrays
        OwnArrays own;

        const OutputMemories& results() const { return is_gathered ? gathered : memories; }
        std::shared_future<void> delivered;
    };
    using HandOn = std::function<void(const HostArrays& values)>;

    /// Without overlap, deliver() reads and hands on itself.
    SlabPipeline(const device::Context& context, bool overlap);
    /// Slabs that were not handed on yet are dropped; waits for the thread.
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
    cl::CommandQueue transfers_;  ///< the context's own without overlap
    std::array<Slot, 2> slots_;
    std::size_t next_slot_ = 0;
    std::shared_future<void> latest_;
    std::atomic<bool> abandoned_ = false;
    bool is_finished_ = false;
};

}  // namespace clsdf::targets

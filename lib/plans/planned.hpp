#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/device.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include "core/lifetime.hpp"
#include "device/buffer_pool.hpp"
#include "plan/grid_plan.hpp"
#include "plan/kept_mesh.hpp"
#include "plans/runs.hpp"

#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

/// Plans: what is prepared once on the device, and its runs, which the host does not wait for.
namespace clsdf::plans {

/// The queue and the events of a run.
struct RunOptions {
    cl_command_queue queue = nullptr;       ///< null: the device's own
    std::span<const cl_event> wait_list{};  ///< the run begins after these
    cl_event* done = nullptr;               ///< gets the event of its end, which the caller releases; may be null
};

/// The part of a plan that is the same whatever it computes. For one thread at a time.
class PlanBase {
public:
    PlanBase(const PlanBase&) = delete;
    PlanBase& operator=(const PlanBase&) = delete;

    device::Context& context() const { return device::context_of(device); }

    /// Throws Error(invalid_argument) if this is not the plan's device.
    void require_device(const Device& other) const;
    /// Throws Error(invalid_argument) if a failed update has left nothing to compute with.
    void require_whole() const;

    const Device device;
    const std::shared_ptr<device::BufferPool> pool;
    const bool has_own_pool;  ///< no other plan or transform takes buffers from it
    SignRule sign = SignRule::none;
    std::size_t failures = 0;       ///< of kernels, before the transform was made that it was made of
    TransformStatistics published;  ///< of making or updating it

protected:
    PlanBase(Device device_in, std::shared_ptr<device::BufferPool> pool_in, bool is_own_pool)
        : device(std::move(device_in)), pool(std::move(pool_in)), has_own_pool(is_own_pool) {}
    ~PlanBase() = default;

    /// Waits for all runs, also for those that fail. Throws Error(device_failure).
    void wait();
    /// Enqueues a run whose commands enqueue(chain) enqueues; there may be none. Throws cl::Error and Error, also if a
    /// kernel has failed since the transform was made.
    void run(const RunOptions& options, const std::function<void(engine::CommandChain&)>& enqueue);

    bool is_whole_ = false;  ///< there is something to compute with
    Runs runs_;
};

/// A plan. Asked: the value that describes what it computes. Made: all that its runs use on the device; nothing when
/// default-constructed.
template <class Asked, class Made>
class Planned : public PlanBase {
public:
    /// Waits for what is under way: the buffers go back to the pool.
    ~Planned() {
        if (runs_.wait() != CL_SUCCESS) keep_for_good(made_);  // commands may still use it
    }

    const Asked& asked() const { return asked_; }

    /// Waits for all runs and gives back what they use. Until the next update() the plan has nothing to compute with.
    void give_back() {
        wait();
        is_whole_ = false;
        made_ = {};
    }

    /// Waits for all runs, sets asked(), and calls make(), which makes what runs use. If that throws, asked() is as
    /// before, and so is what runs use; after give_back() there is nothing to compute with.
    template <class Make>
    void update(Asked others, const Make& make) {
        wait();
        std::swap(asked_, others);
        try {
            make();
        } catch (...) {
            std::swap(asked_, others);
            if (!is_whole_) {
                made_ = {};
                if (has_own_pool) pool->release();
            }
            throw;
        }
        is_whole_ = true;
    }

protected:
    using PlanBase::PlanBase;

    Asked asked_{};
    Made made_{};
};

/// Throws Error(invalid_argument) unless an output has a target exactly if the plan computes it.
void require_target(const OutputInfo& row, bool is_planned, bool has_target);

/// What it took to make plans of slabs, beside what the call took, and their device memory beside what the kept mesh
/// counts. slabs: values with a member `plan`. Slabs of a batch follow one another, and share inputs.
template <class Slabs>
CallStatistics with_slabs(const CallStatistics& call, const Slabs& slabs, const engine::KeptMesh& kept_mesh) {
    CallStatistics sum = call;
    std::size_t bytes = 0;
    engine::Inputs counted;
    for (const auto& slab : slabs) {
        add_slab(sum, slab.plan->statistics);
        engine::Inputs inputs = slab.plan->inputs;
        if (inputs.records == counted.records) inputs.records = nullptr;
        if (inputs.sweep_mesh == counted.sweep_mesh) inputs.sweep_mesh = nullptr;
        bytes += slab.plan->own_bytes() + engine::bytes_beside(kept_mesh, inputs);
        counted = slab.plan->inputs;
    }
    sum.device_bytes = bytes;
    return sum;
}

}  // namespace clsdf::plans

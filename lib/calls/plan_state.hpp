#pragma once

#include <clsdf/distance_transform.hpp>

#include "calls/requests.hpp"
#include "calls/runs.hpp"
#include "calls/stored_boxes.hpp"
#include "core/outputs.hpp"
#include "plan/grid_plan.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::calls {

/// The state of a Plan: a plan for each slab, and the launches that copy samples to the targets. A slab that is one
/// request with packed memory is computed in place. The other slabs are computed one after another in memory that
/// they share, and copied to the targets. For one thread at a time.
struct PlanState {
    /// pool_in: of the plan's buffers. is_own_pool: no other plan or transform takes buffers from it.
    PlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in, bool is_own_pool);
    /// Waits for what is under way: the buffers go back to the pool.
    ~PlanState();
    PlanState(const PlanState&) = delete;
    PlanState& operator=(const PlanState&) = delete;

    /// Divides the requests, with these jobs and targets, into the slabs that are computed. box: the mesh's.
    void divide(std::span<const engine::Job> jobs, std::span<const targets::DeviceTargets> targets, const Box& box);
    const std::vector<Batch>& batches() const { return batches_; }
    const std::vector<Slab>& slabs() const { return slabs_; }
    /// Whether a slab is copied to its targets.
    bool has_copies() const;
    /// Memory for the samples of the largest of the slabs that are copied.
    void make_room();
    /// targets: of all requests.
    void add(const Slab& slab, std::unique_ptr<engine::GridPlan> plan, std::span<const targets::DeviceTargets> targets,
             const engine::Programs& programs);
    /// All slabs have been added. call: what the call that added them took, beside the slabs' plans.
    void complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh);
    /// Waits for all runs, also for those that fail, and gives back what depends on positions and places.
    void clear();

    /// Device memory of this plan, without what the kept mesh counts.
    std::size_t own_bytes(const engine::KeptMesh& kept_mesh) const;

    /// Throws as Plan::enqueue() does if a run cannot write to these targets, one for each request.
    std::vector<targets::DeviceTargets> targets_of(std::span<const OutputTargets> given) const;

    /// targets: of this run alone, as targets_of() returns them; empty: those that were planned.
    cl::Event enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before,
                      std::span<const targets::DeviceTargets> targets);

    /// Adds the counters of the last run, which has ended, to the statistics, if they were asked for.
    void read_counters();

    Device device;
    bool has_own_pool;
    bool counts = false;  ///< runs count the device's work, for read_counters()
    std::shared_ptr<device::BufferPool> pool;
    std::vector<Request> requests;
    std::optional<OutputSet> outputs_without_targets;  ///< of a plan of one grid that was made without memory
    SignRule sign = SignRule::none;
    CallStatistics statistics;
    TransformStatistics published;  ///< of making or updating it
    bool is_whole = false;          ///< all slabs have been added
    std::size_t failures = 0;       ///< of the transform that it was made of

private:
    struct PlannedSlab {
        Slab slab;
        std::unique_ptr<engine::GridPlan> plan;
        targets::TargetArrays like;       ///< of the first request: all have the same types
        engine::OutputBuffers buffers{};  ///< that the samples are computed in
        PerOutput<std::optional<BoxStore>> stores{};
    };
    /// The places of a slab's samples in the targets of its requests.
    PerOutput<std::vector<Place>> places_of(const PlannedSlab& planned,
                                            std::span<const targets::DeviceTargets> targets) const;
    /// Throws if the slab cannot write to the target of one of its requests.
    void check(const PlannedSlab& planned, const targets::DeviceTargets& target) const;
    void enqueue_stores(PlannedSlab& planned, engine::CommandChain& chain,
                        std::span<const targets::DeviceTargets> targets) const;

    std::vector<Batch> batches_;
    std::vector<Slab> slabs_;
    PerOutput<device::BufferPool::Lease> samples_;  ///< of a slab
    std::vector<PlannedSlab> planned_;
    Runs runs_;
};

}  // namespace clsdf::calls

namespace clsdf {

struct __attribute__((visibility("hidden"))) Plan::State : calls::PlanState {
    using PlanState::PlanState;
};

}  // namespace clsdf

#pragma once

#include <clsdf/plan.hpp>

#include "core/outputs.hpp"
#include "plans/planned.hpp"
#include "plans/requests.hpp"
#include "targets/stored_boxes.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::plans {

/// The boxes that a Plan computes.
struct AskedBoxes {
    std::vector<Request> requests{};
    std::optional<OutputSet> outputs_without_targets{};  ///< of a plan of one grid that was made without memory
};

/// A plan for each slab, and the launches that copy samples to the targets.
struct PlannedBoxes {
    struct PlannedSlab {
        Slab slab;
        std::unique_ptr<engine::GridPlan> plan;
        targets::TargetArrays like;       ///< of the first request: all have the same types
        engine::OutputBuffers buffers{};  ///< that the samples are computed in
        PerOutput<std::optional<targets::BoxStore>> stores{};
    };

    std::vector<Batch> batches;
    std::vector<Slab> slabs;
    PerOutput<device::BufferPool::Lease> samples;  ///< of a slab
    std::vector<PlannedSlab> planned;
};

/// The state of a Plan. A slab that is one request with packed memory is computed in place. The other slabs are
/// computed one after another in memory that they share, and copied to the targets.
class PlanState : public Planned<AskedBoxes, PlannedBoxes> {
public:
    /// counts_work: runs count the device's work, for read_counters().
    PlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in, bool is_own_pool, bool counts_work)
        : Planned(std::move(device_in), std::move(pool_in), is_own_pool), counts(counts_work) {}

    // To be called in this order, after give_back().
    /// Divides the requests, with these jobs and targets, into the slabs that are computed. box: the mesh's.
    void divide(std::span<const engine::Job> jobs, std::span<const targets::DeviceTargets> targets, const Box& box);
    const std::vector<Batch>& batches() const { return made_.batches; }
    const std::vector<Slab>& slabs() const { return made_.slabs; }
    /// Whether a slab is copied to its targets.
    bool has_copies() const;
    /// Gives back what was made since divide(), by an attempt that failed.
    void clear();
    /// Memory for the samples of the largest of the slabs that are copied.
    void make_room();
    /// targets: of all requests.
    void add(const Slab& slab, std::unique_ptr<engine::GridPlan> plan, std::span<const targets::DeviceTargets> targets,
             const engine::Programs& programs);
    /// All slabs have been added. call: what the call that added them took, beside the slabs' plans.
    const CallStatistics& complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh);

    /// A run into the targets that were planned. Throws as Plan::enqueue() does.
    void enqueue(const RunOptions& options);
    /// A run into these, one for each request.
    void enqueue(const RunOptions& options, std::span<const OutputTargets> given);

    /// Adds the counters of the last run, which has ended, to the statistics, if they were asked for.
    void read_counters();

    const bool counts;
    CallStatistics statistics;

private:
    using PlannedSlab = PlannedBoxes::PlannedSlab;

    /// Throws as Plan::enqueue() does if a run cannot write to these targets, one for each request.
    std::vector<targets::DeviceTargets> targets_of(std::span<const OutputTargets> given) const;
    /// Throws if the slab cannot write to the target of one of its requests.
    void check(const PlannedSlab& planned, const targets::DeviceTargets& target) const;
    /// The places of a slab's samples in the targets of its requests.
    PerOutput<std::vector<targets::TargetBox>> places_of(const PlannedSlab& planned,
                                                         std::span<const targets::DeviceTargets> targets) const;
    /// targets: of this run alone; empty: those that were planned.
    void enqueue_slabs(engine::CommandChain& chain, std::span<const targets::DeviceTargets> targets);
};

}  // namespace clsdf::plans

namespace clsdf {

struct __attribute__((visibility("hidden"))) Plan::State : plans::PlanState {
    using PlanState::PlanState;
};

}  // namespace clsdf

#pragma once

#include <clsdf/sparse_plan.hpp>

#include "plans/planned.hpp"
#include "plans/requests.hpp"
#include "targets/ordered_bricks.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace clsdf::plans {

/// The field that a SparsePlan computes, and the bricks and runs that its targets have room for.
struct AskedBricks {
    SparseRequest request{};
    SparseCounts room{};
};

/// A plan for each slab, and the memory that the slabs share.
struct PlannedBricks {
    struct PlannedSlab {
        std::unique_ptr<engine::GridPlan> plan;
        targets::BrickStore store;
    };

    std::optional<Batch> batch;
    std::vector<Slab> slabs;
    std::optional<targets::ListedBricks> listed;
    std::vector<PlannedSlab> planned;
};

/// The state of a SparsePlan. The slabs are computed one after another into memory that they share, and appended to the
/// targets in the order of the lattice.
class SparsePlanState : public Planned<AskedBricks, PlannedBricks> {
public:
    SparsePlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in)
        : Planned(std::move(device_in), std::move(pool_in), false) {}

    // To be called in this order, after give_back().
    /// Divides a field's grid, which has whole bricks, into slabs.
    void divide(const engine::Job& job);
    const std::vector<Slab>& slabs() const { return made_.slabs; }
    /// Gives back what was made since divide(), by an attempt that failed.
    void clear();
    /// Memory for the bricks of a slab.
    void make_room();
    void add(std::unique_ptr<engine::GridPlan> plan, const engine::Programs& programs);
    /// All slabs have been added. call: what the call that added them took, beside the slabs' plans.
    CallStatistics complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh) const;

    /// Throws as SparsePlan::enqueue() does.
    void enqueue(const RunOptions& options, const SparseDeviceTargets& given);

private:
    targets::OrderedTargets targets_of(const SparseDeviceTargets& given) const;
};

}  // namespace clsdf::plans

namespace clsdf {

struct __attribute__((visibility("hidden"))) SparsePlan::State : plans::SparsePlanState {
    using SparsePlanState::SparsePlanState;
};

}  // namespace clsdf

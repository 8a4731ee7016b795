#pragma once

#include <clsdf/sparse_plan.hpp>

#include "calls/ordered_bricks.hpp"
#include "calls/requests.hpp"
#include "calls/runs.hpp"
#include "plan/grid_plan.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::calls {

/// The state of a SparsePlan: a plan for each slab. The slabs are computed one after another into memory that they
/// share, and appended to the targets in the order of the lattice. For one thread at a time.
struct SparsePlanState {
    SparsePlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in);
    /// Waits for what is under way: the buffers go back to the pool.
    ~SparsePlanState();
    SparsePlanState(const SparsePlanState&) = delete;
    SparsePlanState& operator=(const SparsePlanState&) = delete;

    /// Divides a field's grid, which has whole bricks, into slabs.
    void divide(const engine::Job& job);
    const Batch& batch() const { return *batch_; }
    const std::vector<Slab>& slabs() const { return slabs_; }
    /// Memory for the bricks of a slab.
    void make_room();
    void add(std::unique_ptr<engine::GridPlan> plan, const engine::Programs& programs);
    /// All slabs have been added. call: what the call that added them took, beside the slabs' plans.
    void complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh);
    /// Waits for all runs, also for those that fail, and gives back what depends on positions and the field.
    void clear();

    /// Throws as SparsePlan::enqueue() does if a run cannot write to these.
    OrderedTargets targets_of(const SparseDeviceTargets& given) const;
    cl::Event enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before, const OrderedTargets& targets);

    Device device;
    std::shared_ptr<device::BufferPool> pool;
    SparseRequest request;
    SparseCounts room;
    SignRule sign = SignRule::none;
    TransformStatistics published;  ///< of making or updating it
    bool is_whole = false;          ///< all slabs have been added
    std::size_t failures = 0;       ///< of the transform that it was made of

private:
    struct PlannedSlab {
        std::unique_ptr<engine::GridPlan> plan;
        BrickOrder order;
    };
    std::size_t own_bytes(const engine::KeptMesh& kept_mesh) const;

    std::optional<Batch> batch_;
    std::vector<Slab> slabs_;
    std::optional<ListedBricks> listed_;
    std::vector<PlannedSlab> planned_;
    Runs runs_;
};

}  // namespace clsdf::calls

namespace clsdf {

struct __attribute__((visibility("hidden"))) SparsePlan::State : calls::SparsePlanState {
    using SparsePlanState::SparsePlanState;
};

}  // namespace clsdf

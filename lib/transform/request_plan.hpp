#pragma once

#include <clsdf/distance_transform.hpp>

#include "core/outputs.hpp"
#include "transform/plan_state.hpp"
#include "transform/requests.hpp"
#include "transform/runs.hpp"
#include "transform/stored_boxes.hpp"

#include <memory>
#include <span>
#include <vector>

namespace clsdf::transform {

/// A plan of requests: a plan for each block, and the launches that copy samples to the targets. A block that is one
/// request with packed memory is computed in place. The other blocks are computed one after another in memory that
/// they share, and copied to the targets. For one thread at a time.
struct RequestPlanState {
    /// pool_in: of the plan's buffers. is_own_pool: no other plan or transform takes buffers from it.
    RequestPlanState(Device device_in, std::vector<Request> requests_in, std::shared_ptr<device::BufferPool> pool_in,
                     bool is_own_pool);
    /// Waits for what is under way: the buffers go back to the pool.
    ~RequestPlanState();
    RequestPlanState(const RequestPlanState&) = delete;
    RequestPlanState& operator=(const RequestPlanState&) = delete;

    /// A block, which is a batch's or a part of it.
    struct Block {
        const Batch* batch;
        Grid grid;
        bool in_place;  ///< the batch is one request, and the block all of it
    };
    /// Memory for the samples of the largest of the blocks that are not computed in place.
    void make_room(std::span<const Block> blocks, std::span<const DeviceTargets> targets);
    void add(const Block& block, std::unique_ptr<PlanState> plan, std::span<const DeviceTargets> targets,
             const Programs& programs);
    /// Waits for all runs, also for those that fail, and gives back what depends on positions and places.
    void clear();

    /// Device memory of this plan, without records that are shared with the transform.
    std::size_t own_bytes() const;

    /// Other targets for a plan of one request, from the next run on. Returns the buffers of that run, if it computes
    /// in place. Throws as Plan::enqueue() does.
    OutputBuffers set_targets(const OutputTargets& targets);

    /// in_place: the buffers of blocks that are computed in place; null: those that they were added with.
    cl::Event enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before,
                      const OutputBuffers* in_place = nullptr);

    Device device;
    bool has_own_pool;
    std::shared_ptr<device::BufferPool> pool;
    std::vector<Request> requests;
    SignRule sign = SignRule::none;
    TransformStatistics statistics;
    bool is_whole = false;  ///< all blocks have been added

private:
    struct Part {
        std::unique_ptr<PlanState> plan;
        bool in_place;
        OutputBuffers buffers;
        std::vector<BoxStore> stores;  ///< in the order of outputs
    };
    template <typename>
    using LeaseOf = device::BufferPool::Lease;

    PerOutput<LeaseOf> samples_;  ///< of a block
    OutputTargets planned_;       ///< of the first request
    std::vector<Part> parts_;
    Runs runs_;
};

}  // namespace clsdf::transform

#pragma once

#include <clsdf/distance_transform.hpp>

#include "core/per_output.hpp"
#include "transform/plan_state.hpp"
#include "transform/requests.hpp"

#include <memory>
#include <span>
#include <vector>

namespace clsdf::transform {

/// Builds the program that stores boxes and, the first time on this device and driver version, tests it. Returns
/// whether it was tested here. Throws Error(device_failure).
bool ensure_store_tested(const Device& device, const Programs& programs, const device::BuildWatch& watch);

/// The plans of the blocks that requests are computed by, one after the other, and the launches that take their samples
/// to the targets. A block that is one request, in packed memory, is computed in place; others by way of memory that
/// all share. For one thread at a time.
struct RequestPlanState {
    RequestPlanState(Device device_in, std::vector<Request> requests_in);
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
    /// Waits for the last run and gives back what depends on positions and places.
    void clear();

    /// Device memory of this plan, without records that are shared with the transform.
    std::size_t own_bytes() const;

    cl::Event enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before);

    Device device;
    std::shared_ptr<device::BufferPool> pool;  ///< of this plan alone
    std::vector<Request> requests;
    TransformStatistics statistics;
    bool is_whole = false;  ///< all blocks have been added

private:
    /// A launch that stores boxes.
    struct Store {
        cl::Kernel kernel;
        cl::NDRange range, group;
    };
    struct Part {
        std::unique_ptr<PlanState> plan;
        OutputBuffers buffers;
        std::vector<Store> stores;
    };
    template <typename>
    using LeaseOf = device::BufferPool::Lease;

    PerOutput<LeaseOf> samples_;  ///< of a block
    std::vector<cl::Buffer> boxes_;
    std::size_t box_bytes_ = 0;
    std::vector<Part> parts_;
    cl::Event last_;
};

}  // namespace clsdf::transform

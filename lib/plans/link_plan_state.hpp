#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/link_plan.hpp>

#include "launch/programs.hpp"
#include "plans/planned.hpp"
#include "segments/device_links.hpp"

#include <cstddef>
#include <memory>
#include <vector>

namespace clsdf::plans {

/// The links that a LinkPlan writes, at most `room` rows.
struct AskedLinks {
    Grid grid;
    std::vector<LinkDirection> directions;
    LinkOptions options;
    std::size_t room = 0;
};

/// The links at positions of a transform, on the device. Without rows if there are more than the plan has room for.
struct PlannedLinks : segments::DeviceLinks {
    std::size_t device_bytes() const { return row_bytes() + totals.bytes(); }

    Lease totals;  ///< a DeviceLinkCount of complete arrays, then one of arrays with too little room
};

/// Enqueue copies to the device: of links that the host has found, or of the number of those that are there.
PlannedLinks uploaded(const device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                      const Links& links, std::size_t room);
PlannedLinks planned(const device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                     segments::DeviceLinks&& links);

/// The state of a LinkPlan.
class LinkPlanState : public Planned<AskedLinks, PlannedLinks> {
public:
    LinkPlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in, engine::Programs programs)
        : Planned(std::move(device_in), std::move(pool_in), false), programs_(std::move(programs)) {}

    /// Runs use this from now on.
    void replace(PlannedLinks made) noexcept { made_ = std::move(made); }

    /// Throws as LinkPlan::enqueue() does.
    void enqueue(const RunOptions& options, const LinkTargets& targets, const DeviceRange& count);

private:
    engine::Programs programs_;
};

}  // namespace clsdf::plans

namespace clsdf {

struct __attribute__((visibility("hidden"))) LinkPlan::State : plans::LinkPlanState {
    using LinkPlanState::LinkPlanState;
};

}  // namespace clsdf

#pragma once

#include <clsdf/fraction_plan.hpp>

#include "cutting/device_fractions.hpp"
#include "launch/programs.hpp"
#include "plans/planned.hpp"
#include "targets/target_overlap.hpp"

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace clsdf::plans {

/// The caller's arrays for rows in memory of the device.
struct StoredRows {
    /// Throws Error(invalid_argument or unsupported). Overlaps are left to the caller.
    StoredRows(const FractionRows& rows, const Grid& grid, const device::Context& context);

    bool has_pieces = false;
    std::vector<cutting::StoredCells> members;
    std::optional<cutting::StoredCells> full;
    std::vector<targets::WrittenArray> written;

    void enqueue(const cutting::DeviceFractions& cuts, const engine::DeviceTools& tools,
                 const engine::Launches& launches) const;
};

/// Whether all arrays that are given are in memory of the device.
bool are_on_device(const FractionRows& rows);

struct AskedFractions {
    Grid grid;
    FractionOptions options;
    std::size_t room = 0;
};

struct PlannedFractions {
    std::optional<cutting::DeviceFractions> cuts;
    device::BufferPool::Lease vertices;
    std::size_t rows = 0;
};

/// The state of a FractionPlan.
class FractionPlanState : public Planned<AskedFractions, PlannedFractions> {
public:
    FractionPlanState(const Device& device_in, std::shared_ptr<device::BufferPool> pool_in)
        : Planned(device_in, std::move(pool_in), true),
          programs(device::context_of(device_in), KernelBody::automatic) {}

    /// between: as DeviceFractions::run_and_make_room(). Nothing has changed if it throws.
    void make(const OuterSurface& surface, AskedFractions asked, const std::function<void(double)>& between);
    /// vertices: null for those of the surface. Throws as FractionPlan::enqueue() does.
    void enqueue(const RunOptions& options, const InputArray* vertices, const FractionRows& rows,
                 const DeviceRange& count);

    const PlannedFractions& made() const { return made_; }
    engine::DeviceTools tools() const { return {context(), pool, programs}; }

    const engine::Programs programs;
};

}  // namespace clsdf::plans

namespace clsdf {

struct __attribute__((visibility("hidden"))) FractionPlan::State : plans::FractionPlanState {
    using FractionPlanState::FractionPlanState;
};

}  // namespace clsdf

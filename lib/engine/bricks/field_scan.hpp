#pragma once

#include <clsdf/grid.hpp>

#include "core/statistics.hpp"
#include "finish/finishing.hpp"
#include "frusta/prepared_mesh.hpp"
#include "launch/commands.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"
#include "lists/surface_points.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace clsdf::engine {

/// The inputs of a plan's scan. The mesh, `finishing` and the memory of the sign bits must outlive the scan; the rest
/// is needed until it is made.
struct ScanInputs {
    DeviceTools tools;
    const Layout& layout;
    const PreparedMesh& mesh;
    const ShortLaunches& launches;  ///< of the set-up
    BrickVariant variant{};
    cl::Buffer sign_bits{};
    // For the scan by bricks alone:
    RecordSelection selection{};                    ///< the records that matter
    std::shared_ptr<const SurfacePoints> points{};  ///< null if the band is so narrow that no bound would be below it
    const Finishing* finishing = nullptr;           ///< null if the distance alone is asked for
    std::span<const Grid> wanted{};                 ///< blocks whose samples are needed; empty: all
    bool in_halves = false;                         ///< the lower slices first: see FieldScan::lower_half()
    bool shares_short_lists = false;                ///< see Inputs
};

/// Computes every sample of a plan's part, in launches of bounded length: by bricks, or as another method does.
class FieldScan {
public:
    virtual ~FieldScan() = default;

    virtual std::size_t launch_count() const = 0;
    /// The share of the work that lies before a launch.
    virtual double fraction_before(std::size_t launch) const = 0;

    /// Enqueues the commands before the first launch, with the outputs of this call.
    virtual void enqueue_begin(CommandChain& chain, const OutputBuffers& outputs) = 0;
    virtual void enqueue_launch(CommandChain& chain, std::size_t launch) = 0;
    /// Enqueues the commands after the last launch.
    virtual void enqueue_end(CommandChain& chain) = 0;

    /// Slices of samples that are complete before the others: after so many launches and enqueue_lower_end().
    struct LowerHalf {
        std::size_t launches = 0;
        std::int32_t slices = 0;
    };
    /// No slices if all are complete at the end.
    virtual LowerHalf lower_half() const { return {}; }
    virtual void enqueue_lower_end(CommandChain&) {}

    /// A mark of each brick, for a sparse field: CLSDF_INSIDE_BRICK, or 1 if it has values. Null: not known.
    virtual cl::Buffer marks() const { return {}; }

    /// Adds the counts of the set-up, and the device memory that it holds.
    virtual void describe(CallStatistics& statistics) const = 0;
    /// Adds the counters of the last computation, if they were asked for; blocks.
    virtual void read_counters(const device::Context& context, CallStatistics& statistics) const = 0;
};

/// The scan of leaned polyhedra by bricks.
std::unique_ptr<FieldScan> make_brick_scan(const ScanInputs& inputs);

}  // namespace clsdf::engine

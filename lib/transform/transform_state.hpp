#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>

#include "core/statistics.hpp"
#include "points/point_query.hpp"
#include "scan/programs.hpp"
#include "scan/slab_pipeline.hpp"
#include "transform/call.hpp"
#include "transform/grid_plan.hpp"
#include "transform/plan_state.hpp"
#include "transform/requests.hpp"
#include "transform/self_test.hpp"
#include "transform/stages.hpp"
#include "transform/vertices.hpp"

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace clsdf {

class FieldMethod;

/// The state of a transform: the mesh and the values made from it, programs, and plans of earlier calls.
struct __attribute__((visibility("hidden"))) DistanceTransform::State {
    /// A plan of an earlier call, which the next call of the same kind takes.
    struct KeptPlan {
        bool count;
        std::unique_ptr<transform::GridPlan> plan;

        bool fits(const Grid& grid, const Band& band, OutputSet outputs, std::span<const Grid> wanted,
                  bool counts) const;
    };

    /// method: of a library beside the core; null: leaned frusta by bricks.
    State(Device device_in, Mesh mesh, const TransformOptions& options, const CallOptions& call,
          std::shared_ptr<const FieldMethod> method_in = nullptr);
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State();

    /// See DistanceTransform::restrict_to().
    std::unique_ptr<State> restricted(std::vector<Region> regions);

    const Mesh& mesh() const { return stages->mesh(); }

    void set_positions(std::span<const Vec3> positions);
    void set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation);

    /// Throws if a computation of such a field is refused, whatever the device does.
    void check(const Grid& grid, const Band& band, OutputSet outputs) const;

    /// Builds and tests, the first time, what such a computation runs on the device.
    bool compile(const Grid& grid, const Band& band, OutputSet outputs, bool count,
                 transform::Compiling& compiling) const;

    /// lone: see Stages::inputs().
    transform::Inputs inputs(const Grid& grid, const Band& band, OutputSet outputs, bool lone = false);
    /// wanted: see PlanOptions. from: where its buffers are taken; null: the transform's pool.
    std::unique_ptr<transform::GridPlan> make_plan(transform::Inputs inputs, const Grid& grid, const Band& band,
                                                   OutputSet outputs, std::span<const Grid> wanted, bool count,
                                                   transform::Caller& caller, transform::Compiling& compiling,
                                                   std::shared_ptr<device::BufferPool> from = nullptr);
    /// The plan of an earlier call like this one, which is the caller's now; null if none is kept.
    std::unique_ptr<transform::GridPlan> take_plan(const Grid& grid, const Band& band, OutputSet outputs,
                                                   std::span<const Grid> wanted, bool count);
    /// Keeps a plan for the next call.
    void keep(std::unique_ptr<transform::GridPlan> plan, bool count);
    /// Drops kept plans and prepared data beyond the budget.
    void keep_within_budget();
    /// Calls keep_within_budget() when a call returns or throws. It is made before the mutex is locked.
    struct KeepsBudget {
        State& state;
        /// Throws as CallMutex::lock() does, so that the destructor does not.
        explicit KeepsBudget(State& state_in) : state(state_in) { state.mutex.check_thread(); }
        KeepsBudget(const KeepsBudget&) = delete;
        KeepsBudget& operator=(const KeepsBudget&) = delete;
        ~KeepsBudget() {
            const std::scoped_lock lock(state.mutex);
            state.keep_within_budget();
        }
    };
    /// Device memory that a kept plan holds, beside what the stages keep themselves.
    std::size_t bytes_of(const transform::GridPlan& plan) const;
    /// Releases what is kept for later calls. Returns whether there was something.
    bool forget();
    /// Returns what make() returns. If memory is short, calls it again when nothing is kept. caller: whose functions it
    /// calls; null: none.
    template <typename Make>
    auto make_room_for(const Make& make, const transform::Caller* caller = nullptr) {
        try {
            return make();
        } catch (const Error& error) {
            const bool is_short =
                caller != nullptr ? caller->is_short_of_memory(error) : error.code() == ErrorCode::out_of_memory;
            if (!is_short || !forget()) throw;
        }
        return make();
    }

    /// The same for points. If memory is still short, gives up the tables for many points and calls make() again.
    template <typename Make>
    auto make_room_for_points(const Make& make) {
        try {
            return make_room_for(make);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::out_of_memory || std::exchange(points_are_short_of_memory, true)) throw;
        }
        return make_room_for(make);
    }

    class SlabRun;  // slab_run.cpp, with compute()

    /// Into packed arrays or, if some have strides, by way of slabs.
    CallStatistics compute_grid(const Grid& grid, const Band& band, OutputSet outputs, const scan::HostTargets& targets,
                                const CallOptions& call);

    CallStatistics compute(std::span<const Request> requests, const CallOptions& call);
    /// Into memory of the device, by way of a plan.
    CallStatistics compute_on_device(std::span<const Request> requests, const CallOptions& call);
    /// Into memory of the host.
    CallStatistics compute_requests(std::span<const Request> requests, const CallOptions& call);

    /// The block of a batch, slab by slab, to the pipeline's sink; of one request, to its targets.
    CallStatistics compute_batch(const transform::Batch& batch, std::span<const Request> requests,
                                 std::span<const scan::HostTargets> targets, scan::SlabPipeline& pipeline,
                                 const CallOptions& call);

    /// Slab by slab, into the arrays or, if not in place, to the sink. wanted: see PlanOptions.
    CallStatistics compute_slabs(const Grid& grid, const Band& band, OutputSet outputs, const scan::HostArrays& arrays,
                                 bool in_place, std::vector<Grid> slabs, std::span<const Grid> wanted,
                                 scan::SlabPipeline& pipeline, const CallOptions& call);

    // plans.cpp
    /// has_own_pool: it takes its buffers from a pool of its own, not from those that the transform uses again.
    /// outputs_without_targets and counts: see PlanState.
    std::unique_ptr<Plan::State> plan(bool has_own_pool, std::vector<Request> requests,
                                      std::optional<OutputSet> outputs_without_targets, const CallOptions& call,
                                      bool counts = false);
    /// Makes the blocks of a plan anew, for these requests.
    void plan(transform::PlanState& made, std::vector<Request> requests,
              std::optional<OutputSet> outputs_without_targets, const CallOptions& call);
    void plan(transform::PlanState& made, std::span<const scan::DeviceTargets> targets, const CallOptions& call);
    /// Adds the plans of all blocks, and what they take to its statistics.
    void add_blocks(transform::PlanState& made, std::span<const transform::PlanState::Block> blocks,
                    std::span<const scan::DeviceTargets> targets, transform::Caller& caller,
                    transform::Compiling& compiling);

    // point_calls.cpp
    std::shared_ptr<const points::PointMesh> points();
    CallStatistics query(std::span<const Vec3> all, double half_width, OutputSet outputs,
                         const scan::HostTargets& targets, const CallOptions& call);

    Device device;
    std::shared_ptr<const FieldMethod> method;
    TransformStatistics setup;  ///< what making it took
    Topology topology;
    SignRule sign = SignRule::none;
    transform::Vertices vertices;
    scan::Programs programs;
    std::shared_ptr<device::BufferPool> pool;

    transform::CallMutex mutex;  // for what follows, and for the work on the device
    std::unique_ptr<transform::Stages> stages;
    std::list<KeptPlan> plans;          // that was used last first
    std::vector<Vec3> first_positions;  // of the transform's mesh, from the first move on
    std::size_t points_asked = 0;       // by query(), since the last move
    /// Since the last move, the device's memory did not suffice for what makes queries of many points faster.
    bool points_are_short_of_memory = false;

private:
    /// With the mesh of other stages.
    State(const State& other, const std::shared_ptr<device::BufferPool>& own_pool,
          std::unique_ptr<transform::Stages> own_stages);

    scan::Programs build_programs(const TransformOptions& options, const CallOptions& call);
    /// Throws Error(unsupported) if the transform is restricted: its vertices are not the caller's.
    void require_whole() const;
    /// For the transform's own mesh.
    void move_vertices(std::vector<Vec3> positions);
    transform::TestCase test_case_of(const Grid& grid, const Band& band, OutputSet outputs, bool count) const;
    bool test(const transform::TestCase& test_case, transform::Compiling& compiling) const;
    transform::Inputs make_inputs(const Grid& grid, const Band& band, OutputSet outputs, bool lone);

    /// For a query of `count` points.
    points::PointInputs point_inputs(OutputSet outputs, std::size_t count);
    /// A part of the points of a query, which asks for `asked` of them, into packed arrays.
    points::PointTimes query(std::span<const Vec3> part, std::size_t asked, double half_width, OutputSet outputs,
                             const scan::HostArrays& arrays, const std::function<void(double)>& between);
};

}  // namespace clsdf

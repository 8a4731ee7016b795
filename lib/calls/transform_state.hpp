#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>

#include "calls/call.hpp"
#include "calls/plan_state.hpp"
#include "calls/requests.hpp"
#include "checks/self_test.hpp"
#include "core/statistics.hpp"
#include "launch/programs.hpp"
#include "mesh/vertices.hpp"
#include "plan/grid_plan.hpp"
#include "plan/kept_mesh.hpp"
#include "points/kept_points.hpp"
#include "points/point_query.hpp"
#include "targets/slab_pipeline.hpp"

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace clsdf {

class FieldMethod;

/// The state of a transform: the mesh and the values made from it, programs, and plans of earlier calls.
struct __attribute__((visibility("hidden"))) DistanceTransform::State : engine::Workshop {
    /// method: of a library beside the core; null: leaned frusta by bricks.
    State(Device device_in, Mesh mesh, const TransformOptions& options, const CallOptions& call,
          std::shared_ptr<const FieldMethod> method_in = nullptr);
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    /// See DistanceTransform::restrict_to().
    std::unique_ptr<State> restricted(std::vector<Region> regions);

    void set_positions(std::span<const Vec3> positions);
    void set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation);

    /// Throws if such a job is refused, whatever the device does.
    void check(const engine::Job& job) const;

    /// The targets of a request after check().
    targets::HostTargets host_targets(const Request& request) const;
    /// outputs_without_targets: see PlanState.
    targets::DeviceTargets device_targets(const Request& request,
                                          const std::optional<OutputSet>& outputs_without_targets = {}) const;

    /// Builds and tests, the first time, what such a job runs on the device.
    void compile(const engine::Job& job, calls::RunningCall& running) const;

    /// The plan of an earlier call with the same job, which is the caller's now; null if none is kept.
    std::unique_ptr<engine::GridPlan> take_plan(const engine::Job& job);
    /// Keeps a plan for the next call.
    void keep(std::unique_ptr<engine::GridPlan> plan);
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
            try {
                state.keep_within_budget();
            } catch (const std::bad_alloc&) {
                // What is kept stays until a later call.
            }
        }
    };
    /// Device memory that a kept plan holds, beside what the kept mesh counts itself.
    std::size_t bytes_of(const engine::GridPlan& plan) const;
    /// Releases what is kept for later calls. Returns whether there was something.
    bool forget();
    /// Forgets what is kept: see with_remedies().
    calls::Remedy forgetting() {
        return {[this] { return forget(); }};
    }
    /// Gives up the tables for many points.
    calls::Remedy without_tables() {
        return {[this] { return !std::exchange(points_are_short_of_memory, true); }};
    }

    class BlockPlans;

    // host_run.cpp
    class HostRun;
    /// By the plan of an earlier call for the same grid; nothing if none is kept, or if memory is short.
    std::optional<CallStatistics> compute_kept(const Request& request, const CallOptions& call);
    CallStatistics compute_on_host(std::span<const Request> requests, const CallOptions& call);
    CallStatistics compute_slabs(const engine::Job& job, const SlabSink& sink, const SlabOptions& options,
                                 const CallOptions& call);

    /// Into memory of the host or of the device, which is that of the first request.
    CallStatistics compute(std::span<const Request> requests, const CallOptions& call);

    // plans.cpp
    /// has_own_pool: it takes its buffers from a pool of its own, not from those that the transform uses again.
    /// outputs_without_targets and counts: see PlanState.
    std::unique_ptr<Plan::State> plan(bool has_own_pool, std::vector<Request> requests,
                                      std::optional<OutputSet> outputs_without_targets, const CallOptions& call,
                                      bool counts = false);
    /// Makes the blocks of a plan anew, for these requests.
    void plan(calls::PlanState& made, std::vector<Request> requests, std::optional<OutputSet> outputs_without_targets,
              const CallOptions& call);
    void plan(calls::PlanState& made, std::span<const targets::DeviceTargets> targets, const CallOptions& call);
    /// By way of a plan.
    CallStatistics compute_on_device(std::span<const Request> requests, const CallOptions& call);

    // point_calls.cpp
    /// By the host, at most points::most_few_points.
    CallStatistics query_few(std::span<const Vec3> all, double half_width, OutputSet outputs,
                             const targets::HostTargets& targets, const CallOptions& call);
    /// By the device.
    CallStatistics query_many(std::span<const Vec3> all, double half_width, OutputSet outputs,
                              const targets::HostTargets& targets, const CallOptions& call);

    Topology topology;
    engine::Vertices vertices;

    CallMutex mutex{"the transform that makes the call"};  // for what follows, and for the work on the device
    std::unique_ptr<engine::KeptMesh> kept_mesh;
    std::unique_ptr<points::KeptPoints> kept_points;
    std::list<std::unique_ptr<engine::GridPlan>> plans;  // of earlier calls; that was used last first
    std::vector<Vec3> first_positions;                   // of the transform's mesh, from the first move on
    std::size_t points_asked = 0;                        // by query(), since the last move
    /// Since the last move, the device's memory did not suffice for what makes queries of many points faster.
    bool points_are_short_of_memory = false;

private:
    /// With another mesh.
    State(const State& other, const std::shared_ptr<device::BufferPool>& own_pool,
          std::unique_ptr<engine::KeptMesh> own_mesh);

    /// Throws Error(unsupported) if the transform is restricted: its vertices are not the caller's.
    void require_whole() const;
    /// For the transform's own mesh.
    void move_vertices(std::vector<Vec3> positions);
    void test(const checks::TestSubject& subject, calls::RunningCall& running) const;

    /// For a query of `count` points. on_host: the host answers it.
    points::PointInputs point_inputs(OutputSet outputs, std::size_t count, bool on_host);
    /// The same for the host, after the checks of the call. Waits for other calls only if something is to be made.
    points::PointInputs inputs_of_few(std::span<const Vec3> all, double half_width, OutputSet outputs,
                                      calls::RunningCall& running);
};

}  // namespace clsdf

#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>

#include "calls/call.hpp"
#include "checks/self_test.hpp"
#include "core/statistics.hpp"
#include "launch/programs.hpp"
#include "plan/grid_plan.hpp"
#include "plan/kept_mesh.hpp"
#include "plans/link_plan_state.hpp"
#include "plans/plan_state.hpp"
#include "plans/point_plan_state.hpp"
#include "plans/requests.hpp"
#include "plans/sparse_plan_state.hpp"
#include "points/kept_points.hpp"
#include "points/point_query.hpp"
#include "points/usable_points.hpp"
#include "segments/device_links.hpp"
#include "targets/output_targets.hpp"
#include "targets/sparse_targets.hpp"

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace clsdf {

class FieldMethod;

/// The state of a transform: the mesh and the values made from it, programs, and plans of earlier calls.
struct __attribute__((visibility("hidden"))) DistanceTransform::State : engine::Workshop {
    /// method: of a library beside the core; null: leaned frusta by bricks.
    State(Device device_in, Mesh mesh, const TransformOptions& options, const CallOptions& call,
          std::shared_ptr<const FieldMethod> method_in = nullptr);
    /// Makes the state of a mesh in memory of the device, which the host does not read. Null if it has to: because it
    /// makes the topology by itself, or because it is to say why this is no mesh.
    static std::unique_ptr<State> of_device_mesh(const Device& device, const MeshView& mesh,
                                                 const TransformOptions& options, const CallOptions& call);
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    /// See DistanceTransform::restrict_to().
    std::unique_ptr<State> restricted(std::vector<Region> regions, double margin);
    std::vector<std::byte> part_bytes();
    static std::unique_ptr<State> of_part(Device device, std::span<const std::byte> bytes,
                                          const TransformOptions& options);
    // shared_transforms.cpp
    std::size_t prepared_bytes();
    void share(std::span<std::byte> memory);
    static std::unique_ptr<State> of_shared(Device device, std::span<const std::byte> memory,
                                            const TransformOptions& options);

    /// Several meshes with the rule and the options of this one: see select_meshes().
    std::unique_ptr<State> joined(engine::JoinedMeshes meshes, bool are_inside_out) const;
    /// Fields are those of some of them, whose numbers ascend.
    void select_meshes(std::vector<std::uint32_t> meshes);
    /// New positions of all of them, which enclose negative volumes or do not, as before.
    void move_joined(std::vector<Vec3> positions);

    void set_positions(std::span<const Vec3> positions, const CallOptions& call);
    /// From memory of the device, which need not come to the host. Returns false, and has done nothing, if it must.
    bool set_positions_on_device(const InputArray& positions);
    void set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation);

    FieldDescription description_of(const Grid& grid, const Band& band) const {
        return {.grid = grid, .band = band, .sign = sign, .mesh_name = kept_mesh->name(), .floor = floor};
    }
    /// The job of what is asked for. Throws if it is refused, whatever the device does.
    engine::Job check(engine::JobKey asked) const;
    /// For plans::targets_of(): functions that check a request, add its job to `jobs` and return its targets.
    auto host_targets(std::vector<engine::Job>& jobs, bool counts = false) const {
        return [this, &jobs, counts](const Request& request) -> targets::HostTargets {
            jobs.push_back(check({request.grid, request.band, targets::outputs_of(request.targets), {}, counts}));
            return {request.targets, request.grid};
        };
    }
    /// outputs_without_targets: see AskedBoxes.
    auto device_targets(std::vector<engine::Job>& jobs, const std::optional<OutputSet>& outputs_without_targets = {},
                        bool counts = false) const {
        return [this, &jobs, outputs_without_targets, counts](const Request& request) -> targets::DeviceTargets {
            const OutputSet outputs = outputs_without_targets.value_or(targets::outputs_of(request.targets));
            jobs.push_back(check({request.grid, request.band, outputs, {}, counts}));
            if (outputs_without_targets) return {outputs, request.grid};
            return {request.targets, request.grid, context()};
        };
    }

    /// Builds and tests, the first time, what such a job runs on the device, and others beside it.
    void compile(const engine::Job& job, calls::RunningCall& running,
                 std::vector<checks::TestSubject> others = {}) const;

    /// The plan of an earlier call for the same, which is the caller's now; null if none is kept.
    std::unique_ptr<engine::GridPlan> take_plan(const engine::JobKey& asked);
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
            state.keep_within_budget();
        }
    };
    /// Device memory that a kept plan holds, beside what the kept mesh counts itself.
    std::size_t bytes_of(const engine::GridPlan& plan) const;
    /// Releases what is kept for later calls; reads what only the device has before. Returns whether there was
    /// something. Throws Error.
    bool forget();
    /// Forgets what is kept: see with_remedies().
    calls::Remedy forgetting() {
        return {[this] { return forget(); }};
    }
    /// For a query of `most` points at once: forgets, halves `most`, gives up the tables.
    std::vector<calls::Remedy> remedies_for_points(std::size_t& most);
    /// Gives up the tables for many points.
    calls::Remedy without_tables() {
        return {[this] { return !std::exchange(points_are_short_of_memory, true); }};
    }

    /// The values of the mesh that finishing needs for these outputs, beside their names: normals, and whether they
    /// point inside.
    struct NormalsNeeded {
        bool are_needed;
        bool is_inside_out;
    };
    NormalsNeeded normals_for(OutputSet outputs);

    class SlabPlans;

    /// Into memory of the host or of the device, which is that of the first request.
    CallStatistics compute(std::span<const Request> requests, const CallOptions& call);

    // host_run.cpp
    class HostRun;
    /// wanted: blocks of one request, whose other samples may stay as they are; empty: all.
    CallStatistics compute_on_host(std::span<const Request> requests, const CallOptions& call,
                                   std::span<const Grid> wanted = {});
    CallStatistics compute_slabs(const engine::Job& job, const SlabSink& sink, const SlabOptions& options,
                                 const CallOptions& call);

    // sparse_run.cpp
    class SparseRun;
    /// The job of a sparse field: of whole bricks. Throws if it is refused.
    engine::Job check_sparse(const Grid& grid, const Band& band, OutputSet extras, bool counts) const;
    CallStatistics compute_sparse(const engine::Job& job, const SparseSink& sink, const CallOptions& call);
    /// Sets the bricks, the runs and the values of the field, whose description is set.
    CallStatistics compute_sparse(const engine::Job& job, SparseField& field, const CallOptions& call);
    /// counts: of the field, also if the arrays have less room.
    CallStatistics compute_sparse(const engine::Job& job, const targets::SparseArrays& arrays, SparseCounts& counts,
                                  const CallOptions& call);
    /// A field for each job, whose description is set.
    CallStatistics compute_sparse(std::span<const engine::Job> jobs, std::span<SparseField> fields,
                                  const CallOptions& call);

    // block_sets.cpp
    CallStatistics compute(const BlockSet& blocks, const CallOptions& call);
    /// Throws if one of the blocks is refused, or if their arrays overlap.
    void check_all(const BlockSet& blocks) const;

    // planning.hpp
    template <class Plan, class Asked, class MakeParts>
    void make(Plan& plan, Asked asked, const CallOptions& call, const MakeParts& make_parts);
    void make_and_wait(calls::RunningCall& running, const std::function<void()>& enqueue);
    template <class Plan, class Add>
    void set_up_slabs(Plan& plan, calls::RunningCall& running, const Add& add);

    // plans.cpp
    /// has_own_pool: it takes its buffers from a pool of its own, not from those that the transform uses again.
    /// counts: see PlanState.
    std::unique_ptr<Plan::State> plan(bool has_own_pool, plans::AskedBoxes asked, const CallOptions& call,
                                      bool counts = false);
    /// Makes a plan, or makes it anew, for these boxes, this field, these points.
    void plan(plans::PlanState& plan, plans::AskedBoxes asked, const CallOptions& call);
    void plan(plans::SparsePlanState& plan, const plans::AskedBricks& asked, const CallOptions& call);
    void plan(plans::PointPlanState& plan, const plans::AskedPoints& asked, const CallOptions& call);
    /// Links of a plan, in memory of the device if kernels find them, and what that took.
    struct FoundLinks {
        std::optional<segments::DeviceLinks> on_device;
        Links on_host;
        TransformStatistics statistics;
    };
    FoundLinks find_planned_links(const plans::AskedLinks& asked, const CallOptions& call);
    void plan(plans::LinkPlanState& plan, const plans::AskedLinks& asked, FoundLinks found, const CallOptions& call);
    /// Stores links that are on the device in arrays there, which have room for them. Waits.
    TransformStatistics store(const plans::AskedLinks& asked, FoundLinks found, const LinkTargets& targets,
                              const CallOptions& call);
    /// By way of a plan.
    CallStatistics compute_on_device(std::span<const Request> requests, const CallOptions& call);

    // point_calls.cpp
    /// By the host, at most points::most_few_points.
    CallStatistics query_few(points::UsablePoints& asked, double half_width, OutputSet outputs,
                             const targets::HostTargets& targets, const CallOptions& call);
    /// By the device.
    CallStatistics query_many(points::UsablePoints& asked, double half_width, OutputSet outputs,
                              const targets::HostTargets& targets, const CallOptions& call);

    /// Whether points and results in memory of the device stay there. The checks of the call have been made.
    bool stay_on_device(const InputArray& points, const OutputTargets& targets) const;
    /// By the device, of which the host sees a short list. warning: about points that are not usable.
    CallStatistics query_on_device(const InputArray& points, double half_width, OutputSet outputs,
                                   const OutputTargets& targets, const CallOptions& call, std::string& warning);

    /// What the host answers few points with. Waits for other calls only if something is to be made; check(box), which
    /// may throw, is called before with the mesh's box.
    points::PointInputs inputs_of_few(OutputSet outputs, std::size_t count, calls::RunningCall& running,
                                      const std::function<void(const Box&)>& check);

    struct WindingInputs {
        std::shared_ptr<const engine::PointMesh> mesh;
        std::shared_ptr<const engine::WideTree> tree;
        std::shared_ptr<const OpenBoundary> boundary;  ///< never null
    };
    /// Throws as DistanceTransform::winding() does.
    WindingInputs winding_inputs();

    // link_calls.cpp
    /// Calls find(inputs) with what links of the grid need. margin: samples that they reach beyond it. Throws as
    /// DistanceTransform::links() does.
    /// If kernels may find them, by_kernels(inputs) is called before, unless it is empty; it returns whether it has.
    using FindByKernels = std::function<bool(const segments::DeviceLinkInputs&)>;
    template <typename Find>
    CallStatistics find_links(const Grid& grid, const std::array<std::int32_t, 3>& margin, Hits hits,
                              const CallOptions& call, const Find& find, const FindByKernels& by_kernels = {});
    /// False if the host has to find the links: also if the device is short of memory.
    bool find_links_by_kernels(const FindByKernels& find, calls::RunningCall& running);

    // segment_calls.cpp
    struct SegmentInputs {
        std::shared_ptr<const engine::PointMesh> mesh;
        std::shared_ptr<const engine::WideTree> tree;
        std::shared_ptr<const engine::CrossedExtent> extent;
    };
    /// The floor if walls of the rule `below` are asked for.
    std::optional<double> floor_of(Hits hits) const { return hits == Hits::walls ? floor : std::nullopt; }
    /// Throws as DistanceTransform::rays() does.
    SegmentInputs segment_inputs(Hits hits);
    /// Looks up rays or pairs of points: warn(mesh, unusable) sets how many are not usable and returns what to say of
    /// them, find(searched, begin, end) looks up some.
    template <typename Warn, typename Find>
    CallStatistics look_up_pairs(std::size_t count, const CallOptions& call, Hits hits, const Warn& warn,
                                 const Find& find);

    /// Throws Error(device_failure) if a kernel has failed since this was made: what is kept may be wrong.
    void require_sound() const { context().require_none_failed(failures); }

    Topology topology;
    std::optional<double> floor;                  // of the sign rule `below`
    std::size_t failures = context().failures();  // of kernels, before any was launched

    CallMutex mutex{"the transform that makes the call"};  // for what follows, and for the work on the device
    std::unique_ptr<engine::KeptMesh> kept_mesh;
    std::unique_ptr<points::KeptPoints> kept_points;
    std::list<std::unique_ptr<engine::GridPlan>> plans;  // of earlier calls; that was used last first
    std::size_t points_asked = 0;                        // by query(), since the last move
    /// Of TransformOptions::surface outer: what the surface is made of, anew when vertices move. Null in a restricted
    /// transform.
    struct GivenMesh {
        Mesh mesh;
        engine::Vertices vertices;  ///< the caller's, as the mesh has them
        TransformOptions options;
        bool has_moved = false;  ///< the surface is that of other positions
    };
    std::unique_ptr<GivenMesh> given;
    std::size_t given_bytes() const {
        if (!given) return 0;
        return given->mesh.vertices().size() * sizeof(Vec3) + given->mesh.triangles().size() * sizeof(Triangle);
    }
    /// Since the last move, the device's memory did not suffice for what makes queries of many points faster.
    bool points_are_short_of_memory = false;

private:
    /// With another mesh.
    State(const State& other, const std::shared_ptr<device::BufferPool>& own_pool,
          std::unique_ptr<engine::KeptMesh> own_mesh);

    /// Without a mesh.
    State(Device device_in, const TransformOptions& options, const CallOptions& call,
          std::shared_ptr<const FieldMethod> method_in);
    /// Sets the mesh, or its outer surface, by kernels if they make the topology.
    void set_given(Mesh mesh, const TransformOptions& options, const CallOptions& call);
    void set_outer(const Mesh& mesh, const TransformOptions& options, const CallOptions& call);
    /// The mesh of another outer surface in the place of this one: set() sets it. If it throws, all stays as it was.
    void replace_outer(const std::function<void()>& set);
    /// Each sets the mesh and all that describes it.
    void set_mesh(Mesh mesh, const TransformOptions& options, const CallOptions& call);
    /// made: by kernels, of the mesh as given; it has the mesh's arrays if `given` is null.
    void set_mesh(std::shared_ptr<const Mesh> given, engine::MadeTopology made, const TransformOptions& options,
                  const CallOptions& call);
    /// Sets the sign by the surface that decides it, the last of them.
    void set_sign(SignSurface surface, const TransformOptions& options, const CallOptions& call);
    engine::KeptMesh::Options kept_options(const TransformOptions& options) const {
        return {programs, method, options.kept_bytes};
    }
    /// Returns what make(set_up), make_device_topology(), returns, by kernels that are tested; nothing if the host is
    /// to make the topology of so many vertices and faces.
    template <class Make>
    std::optional<engine::MadeTopology> make_topology(std::size_t vertex_count, std::size_t face_count,
                                                      const CallOptions& call, const Make& make) const;
    /// Throws Error(unsupported) if the transform is restricted, and, for is_movable, has no margin.
    void require_mobile(bool is_movable) const;
    /// For the transform's own mesh.
    void move_vertices(std::vector<Vec3> positions);
    /// Returns what move() returns: whether it has moved the kept mesh.
    template <class Move>
    bool move_by(const Move& move);
    void test(std::span<const checks::TestSubject> subjects, calls::RunningCall& running) const;
    void test(const checks::TestSubject& subject, calls::RunningCall& running) const {
        test(std::span(&subject, 1), running);
    }

    /// For a query of `count` points. on_host: the host answers it.
    points::PointInputs point_inputs(OutputSet outputs, std::size_t count, bool on_host);
    /// For plans of points: all that may be needed. Throws Error(invalid_argument) if kernels cannot decide signs.
    points::PointInputs planned_point_inputs(OutputSet outputs);
    /// For queries by the device, whose search is tested.
    points::PointInputs inputs_of_many(OutputSet outputs, std::size_t count, calls::RunningCall& running);
    /// Finds the points that are not usable. Throws if they, or points beyond the regions, are refused.
    void find_usable(points::UsablePoints& asked, const Box& box, double half_width) const;
};

}  // namespace clsdf

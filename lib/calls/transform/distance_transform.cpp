#include <clsdf/distance_transform.hpp>

#include "calls/transform/transform_access.hpp"
#include "calls/transform/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/outputs.hpp"
#include "core/refuse.hpp"
#include "plan/slabs.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/output_targets.hpp"

#include <limits>
#include <mutex>
#include <utility>

namespace clsdf {

const char* name_of(Surface surface) {
    return surface == Surface::outer ? "outer" : surface == Surface::given ? "given" : "unknown";
}

DistanceTransform::DistanceTransform(Device device, const Mesh& mesh, const TransformOptions& options,
                                     const CallOptions& call)
    : state_(with_host_memory("for the mesh", [&] {
          targets::wait_for(device::context_of(device), call.wait_list);
          return std::make_unique<State>(std::move(device), mesh, options, call);
      })) {}
DistanceTransform::DistanceTransform(Device device, const MeshView& mesh, const TransformOptions& options,
                                     const CallOptions& call) {
    with_host_memory("for the mesh", [&] {
        targets::MappedMemory memory(device::context_of(device));
        memory.add_triples(mesh.vertices(), "vertices");
        memory.add_triples(mesh.triangles(), "triangles");
        targets::wait_for(device::context_of(device), call.wait_list);
        if ((state_ = State::of_device_mesh(device, mesh, options, call))) return;
        memory.map({});
        Mesh copy(MeshView(memory.mapped(mesh.vertices()), memory.mapped(mesh.triangles())));
        memory.unmap();
        state_ = std::make_unique<State>(std::move(device), std::move(copy), options, call);
    });
}
DistanceTransform::DistanceTransform(std::unique_ptr<State> state) : state_(std::move(state)) {}
DistanceTransform::DistanceTransform(DistanceTransform&&) noexcept = default;
DistanceTransform& DistanceTransform::operator=(DistanceTransform&&) noexcept = default;
DistanceTransform::~DistanceTransform() = default;

DistanceTransform detail::TransformAccess::make(Device device, const Mesh& mesh,
                                                std::shared_ptr<const FieldMethod> method,
                                                const TransformOptions& options, const CallOptions& call) {
    return with_host_memory("for the mesh", [&] {
        return DistanceTransform(
            std::make_unique<DistanceTransform::State>(std::move(device), mesh, options, call, std::move(method)));
    });
}

DistanceTransform detail::TransformAccess::of(std::unique_ptr<DistanceTransform::State> state) {
    return DistanceTransform(std::move(state));
}

DistanceTransform::State& DistanceTransform::state() const {
    State& state = held_by(state_, "DistanceTransform");
    state.require_sound();
    return state;
}

const Topology& DistanceTransform::topology() const {
    return held_by(state_, "DistanceTransform").topology;
}
SignRule DistanceTransform::sign() const {
    return held_by(state_, "DistanceTransform").sign;
}
std::optional<double> DistanceTransform::floor() const {
    return held_by(state_, "DistanceTransform").floor;
}
std::string DistanceTransform::mesh_name() const {
    State& state = held_by(state_, "DistanceTransform");
    const std::scoped_lock lock(state.mutex);
    return state.kept_mesh->name();
}
Device DistanceTransform::device() const {
    return held_by(state_, "DistanceTransform").device;
}
Box DistanceTransform::box() const {
    State& state = held_by(state_, "DistanceTransform");
    const std::scoped_lock lock(state.mutex);
    return state.kept_mesh->box();
}
DistanceTransform DistanceTransform::restrict_to(std::span<const Region> regions, double margin) const {
    return with_host_memory("to restrict the transform", [&] {
        return DistanceTransform(state().restricted({regions.begin(), regions.end()}, margin));
    });
}
std::vector<std::uint32_t> DistanceTransform::part_vertices() const {
    State& state = held_by(state_, "DistanceTransform");
    const std::scoped_lock lock(state.mutex);
    const engine::MovablePart* movable = state.kept_mesh->movable();
    if (movable == nullptr)
        refuse_unsupported(
            "the numbers of a part's vertices are those of one that takes positions; restrict the whole "
            "transform with a margin");
    return with_host_memory("for the numbers of the vertices", [&] { return movable->numbers; });
}
std::vector<std::byte> DistanceTransform::part_bytes() const {
    return with_host_memory("for the bytes of the part", [&] { return state().part_bytes(); });
}
DistanceTransform DistanceTransform::from_part(Device device, std::span<const std::byte> bytes,
                                               std::optional<std::size_t> kept_bytes) {
    return with_host_memory("for the part", [&] {
        TransformOptions options;
        options.kept_bytes = kept_bytes;
        return DistanceTransform(State::of_part(std::move(device), bytes, options));
    });
}
std::size_t DistanceTransform::prepared_bytes() const {
    return with_host_memory("to prepare the mesh", [&] { return state().prepared_bytes(); });
}
void DistanceTransform::share(std::span<std::byte> memory) const {
    with_host_memory("to prepare the mesh", [&] { state().share(memory); });
}
DistanceTransform DistanceTransform::from_shared(Device device, std::span<const std::byte> memory,
                                                 std::optional<std::size_t> kept_bytes) {
    return with_host_memory("for the transform", [&] {
        TransformOptions options;
        options.kept_bytes = kept_bytes;
        return DistanceTransform(State::of_shared(std::move(device), memory, options));
    });
}
void DistanceTransform::set_positions(const InputArray& positions, const CallOptions& call) {
    with_host_memory("for the positions", [&] {
        State& state = this->state();
        check_array(positions, ArrayKind::positions, "positions", ErrorCode::invalid_argument);
        targets::MappedMemory memory(device::context_of(state.device));
        memory.add_triples(positions, "positions");
        if (positions.device != nullptr) {
            targets::wait_for(device::context_of(state.device), call.wait_list);
            if (state.set_positions_on_device(positions)) return;
        }
        memory.map(call.wait_list);
        const PositionArray array(memory.mapped(positions));
        std::vector<Vec3> copy;
        if (positions.device != nullptr) {
            copy.assign(array.get().begin(), array.get().end());
            memory.unmap();  // which may fail, before anything has moved
        }
        state.set_positions(copy.empty() ? array.get() : copy, call);
    });
}
void DistanceTransform::set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    with_host_memory("for the positions", [&] { state().set_motion(rotation, translation); });
}

KeptMemory DistanceTransform::memory() const {
    State& state = held_by(state_, "DistanceTransform");
    const std::scoped_lock lock(state.mutex);
    KeptMemory memory = state.kept_mesh->memory();
    memory.host_bytes += state.given_bytes();
    memory.shared_host_bytes = state.context().shared_host_bytes();
    memory.shared_device_bytes = state.context().arena().free_bytes();
    for (const auto& plan : state.plans) memory.device_bytes += state.bytes_of(*plan);
    return memory;
}

TransformStatistics DistanceTransform::compile(const Grid& grid, const Band& band, OutputSet outputs,
                                               const CallOptions& call) const {
    return with_host_memory("to compile", [&] {
        State& state = this->state();
        calls::RunningCall running{call};
        running.throw_if_stopped();
        const std::scoped_lock lock(state.mutex);
        state.compile(state.check({grid, band, targets::extras_of(outputs), {}, call.count_work}), running);
        return running.statistics.published();
    });
}

TransformStatistics DistanceTransform::compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                               const CallOptions& call) const {
    const Request request{grid, band, targets};
    return compute({&request, 1}, call);
}

TransformStatistics DistanceTransform::compute(std::span<const Request> requests, const CallOptions& call) const {
    return with_host_memory("for the computation; compute less at once",
                            [&] { return state().compute(requests, call).published(); });
}

TransformStatistics DistanceTransform::compute(const BlockSet& blocks, const CallOptions& call) const {
    return with_host_memory("for the blocks; compute fewer at once",
                            [&] { return state().compute(blocks, call).published(); });
}

TransformStatistics DistanceTransform::compute(const Grid& grid, const Band& band, OutputSet outputs,
                                               const SlabSink& sink, const SlabOptions& options,
                                               const CallOptions& call) const {
    return with_host_memory("for the slabs; compute a part of the grid", [&] {
        State& state = this->state();
        grid.validate();
        grid.sample_count();
        const engine::Job job = state.check({grid, band, targets::extras_of(outputs), {}, call.count_work});
        if (!sink) refuse("a field in slabs needs a sink, and it is empty");
        targets::wait_for(state.context(), call.wait_list);
        return state.compute_slabs(job, sink, options, call).published();
    });
}

TransformStatistics DistanceTransform::compute_sparse(const Grid& grid, const Band& band, OutputSet outputs,
                                                      const SparseSink& sink, const CallOptions& call) const {
    return with_host_memory("for the sparse field; compute a part of the grid", [&] {
        State& state = this->state();
        const engine::Job job = state.check_sparse(grid, band, targets::extras_of(outputs), call.count_work);
        if (!sink) refuse("a sparse field in layers needs a sink, and it is empty");
        targets::wait_for(state.context(), call.wait_list);
        return state.compute_sparse(job, sink, call).published();
    });
}

SparseField DistanceTransform::compute_sparse(const Grid& grid, const Band& band, OutputSet outputs,
                                              const CallOptions& call, TransformStatistics* statistics) const {
    return with_host_memory("for the sparse field; hand it to a sink, or compute a part of the grid", [&] {
        State& state = this->state();
        const engine::Job job = state.check_sparse(grid, band, targets::extras_of(outputs), call.count_work);
        targets::wait_for(state.context(), call.wait_list);
        SparseField field;
        static_cast<FieldDescription&>(field) = state.description_of(grid, band);
        const CallStatistics made = state.compute_sparse(job, field, call);
        if (statistics != nullptr) *statistics = made.published();
        return field;
    });
}

TransformStatistics DistanceTransform::compute_sparse(const Grid& grid, const Band& band, const SparseTargets& targets,
                                                      SparseCounts& counts, const CallOptions& call) const {
    counts = {};
    return with_host_memory("for the sparse field; compute a part of the grid", [&] {
        State& state = this->state();
        const OutputSet extras = targets::extras_of(targets.values.outputs());
        const engine::Job job = state.check_sparse(grid, band, extras, call.count_work);
        const targets::SparseArrays arrays(targets);
        targets::wait_for(state.context(), call.wait_list);
        SparseCounts found;
        const CallStatistics made = state.compute_sparse(job, arrays, found, call);
        counts = found;
        arrays.check_room(counts);
        return made.published();
    });
}

SparseCounts DistanceTransform::count_sparse(const Grid& grid, const Band& band, const CallOptions& call,
                                             TransformStatistics* statistics) const {
    return with_host_memory("for the sparse field; count a part of the grid", [&] {
        State& state = this->state();
        const engine::Job job = state.check_sparse(grid, band, {}, call.count_work);
        targets::wait_for(state.context(), call.wait_list);
        SparseCounts counts;
        const CallStatistics made = state.compute_sparse(job, targets::SparseArrays(), counts, call);
        if (statistics != nullptr) *statistics = made.published();
        return counts;
    });
}

std::vector<SparseField> DistanceTransform::compute_sparse(std::span<const SparseRequest> requests,
                                                           const CallOptions& call,
                                                           TransformStatistics* statistics) const {
    return with_host_memory("for the sparse fields; compute fewer at once", [&] {
        State& state = this->state();
        std::vector<engine::Job> jobs;
        std::vector<SparseField> fields;
        for (const auto& [grid, band, outputs] : requests) {
            jobs.push_back(plans::for_request(jobs.size(), requests.size(), [&] {
                return state.check_sparse(grid, band, targets::extras_of(outputs), call.count_work);
            }));
            static_cast<FieldDescription&>(fields.emplace_back()) = state.description_of(grid, band);
        }
        targets::wait_for(state.context(), call.wait_list);
        const CallStatistics made = state.compute_sparse(jobs, fields, call);
        if (statistics != nullptr) *statistics = made.published();
        return fields;
    });
}

std::vector<Grid> DistanceTransform::slabs_of(const Grid& grid) {
    grid.validate();
    device::Context::Capabilities unlimited;
    unlimited.memory = unlimited.largest_allocation = std::numeric_limits<std::size_t>::max();
    engine::check_grid(grid);
    return with_host_memory("for the list of slabs",
                            [&] { return engine::slabs_of(grid, engine::stream_limits_of(unlimited)); });
}

Field DistanceTransform::compute(const Grid& grid, const Band& band, OutputSet outputs, const CallOptions& call,
                                 TransformStatistics* statistics) const {
    const State& state = this->state();
    Field field(state.description_of(grid, band), targets::extras_of(outputs) | Output::distance);
    try {
        const Request request{grid, band, field.targets()};
        const TransformStatistics made = compute({&request, 1}, call);
        if (statistics != nullptr) *statistics = made;
    } catch (...) {
        if (state.context().is_lost()) keep_for_good(field);
        throw;
    }
    return field;
}

}  // namespace clsdf

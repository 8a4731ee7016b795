#include "calls/transform/transform_state.hpp"

#include "core/refuse.hpp"
#include "cutting/outer_mesh.hpp"
#include "mesh/equal_vertices.hpp"
#include "plan/field_method.hpp"
#include "points/box_places.hpp"
#include "surface/parts.hpp"
#include "surface/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <utility>

namespace clsdf {

namespace {

/// For the grids of a time step. More would keep the memory that the next one needs.
constexpr std::size_t most_plans = 4;

void check_floor(const TransformOptions& options) {
    if (options.sign == SignRule::below && !options.floor)
        refuse("the sign rule below needs a floor, to which walls go down from the rim; give its z (--floor)");
    if (options.sign != SignRule::below && options.floor)
        refuse(
            "a floor, at z = {}, is for the sign rule below, and the rule is {}; leave it out, or "
            "choose the sign rule below",
            *options.floor, name_of(options.sign));
}

engine::Workshop workshop_of(Device device, std::shared_ptr<const FieldMethod> method, const TransformOptions& options,
                             const CallOptions& call) {
    calls::RunningCall{call}.throw_if_stopped();
    check_floor(options);
    engine::Programs programs =
        device::guarded([&] { return engine::Programs(device::context_of(device), options.body); });
    auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    return {std::move(device), std::move(pool), std::move(programs), std::move(method)};
}

/// Memory of the device that kernels may read; the host may read all.
bool kernels_can_read(const InputArray& array) {
    return array.device != nullptr && device::guarded([&] {
               return (cl::Buffer(array.device, true).getInfo<CL_MEM_FLAGS>() & CL_MEM_WRITE_ONLY) == 0;
           });
}

}  // namespace

DistanceTransform::State::State(Device device_in, Mesh mesh, const TransformOptions& options, const CallOptions& call,
                                std::shared_ptr<const FieldMethod> method_in)
    : State(std::move(device_in), options, call, std::move(method_in)) {
    if (options.surface == Surface::given) {
        set_given(std::move(mesh), options, call);
        return;
    }
    if (method)
        refuse_unsupported(
            "polyhedra and scans of clsdf::papers take the surface as given; give them the mesh of outer()");
    set_outer(mesh, options, call);
    engine::Vertices vertices(mesh.vertices().size());
    if (topology.coincident_vertices > 0) vertices = engine::Vertices(mesh, first_equal_vertices(mesh.vertices()));
    given = std::make_unique<GivenMesh>(std::move(mesh), std::move(vertices), options);
}

void DistanceTransform::State::set_given(Mesh mesh, const TransformOptions& options, const CallOptions& call) {
    auto made =
        make_topology(mesh.vertices().size(), mesh.triangles().size(), call,
                      [&](const engine::DeviceSetUp& set_up) { return engine::make_device_topology(set_up, mesh); });
    if (made)
        set_mesh(std::make_shared<const Mesh>(std::move(mesh)), std::move(*made), options, call);
    else
        set_mesh(std::move(mesh), options, call);
}

void DistanceTransform::State::set_outer(const Mesh& mesh, const TransformOptions& options, const CallOptions& call) {
    cutting::OuterMesh outer = cutting::outer_mesh(mesh, options.sign, call);
    if (outer.faces.numbers.empty()) return set_given(mesh, options, call);
    TransformOptions of_outer = options;
    of_outer.sign = outer.rule;
    CallOptions without_log = call;
    without_log.log = {};
    set_given(std::move(outer.surface.mesh), of_outer, without_log);
    kept_mesh->set_given_faces(std::move(outer.faces));
    topology = std::move(outer.topology);
    if (!outer.warning.empty() && call.log) call.log(outer.warning);
}

void DistanceTransform::State::replace_outer(const std::function<void()>& set) {
    plans.clear();
    auto mesh = std::move(kept_mesh);
    auto points = std::move(kept_points);
    Topology described = topology;
    const SignRule rule = sign;
    try {
        set();
    } catch (...) {
        kept_points.reset();
        kept_mesh = std::move(mesh);
        kept_points = std::move(points);
        topology = std::move(described);
        sign = rule;
        throw;
    }
    points.reset();  // before its mesh
    points_asked = 0;
    points_are_short_of_memory = false;
}

DistanceTransform::State::State(Device device_in, const TransformOptions& options, const CallOptions& call,
                                std::shared_ptr<const FieldMethod> method_in)
    : engine::Workshop(workshop_of(std::move(device_in), std::move(method_in), options, call)) {}

std::unique_ptr<DistanceTransform::State> DistanceTransform::State::of_device_mesh(const Device& device,
                                                                                   const MeshView& mesh,
                                                                                   const TransformOptions& options,
                                                                                   const CallOptions& call) {
    const InputArray &vertices = mesh.vertices(), &triangles = mesh.triangles();
    if (options.surface == Surface::outer) return nullptr;
    if (!kernels_can_read(vertices) || !kernels_can_read(triangles)) return nullptr;
    std::unique_ptr<State> state(new State(device, options, call, nullptr));
    auto made = state->make_topology(vertices.count, triangles.count, call, [&](const engine::DeviceSetUp& set_up) {
        return engine::make_device_topology(set_up, engine::device_triples(vertices),
                                            engine::device_triples(triangles));
    });
    if (!made) return nullptr;
    state->set_mesh(nullptr, std::move(*made), options, call);
    return state;
}

void DistanceTransform::State::set_mesh(Mesh mesh, const TransformOptions& options, const CallOptions& call) {
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    topology = describe_vertices(mesh, first);
    engine::Vertices vertices(mesh.vertices().size());
    if (topology.coincident_vertices > 0) vertices = engine::Vertices(mesh, first);
    kept_mesh = std::make_unique<engine::KeptMesh>(context(), pool, std::move(mesh), std::move(vertices),
                                                   kept_options(options));
    const engine::MeshTopology& of_mesh = kept_mesh->topology();
    set_sign(
        describe_edges(kept_mesh->mesh(), of_mesh.faces.triangles, of_mesh.edges.are_paired, options.sign, topology),
        options, call);
}

void DistanceTransform::State::set_mesh(std::shared_ptr<const Mesh> mesh, engine::MadeTopology made,
                                        const TransformOptions& options, const CallOptions& call) {
    const TopologyResults& found = made.results;
    topology = {};
    topology.unused_vertices = made.given_vertices - found.used_vertices;
    topology.coincident_vertices = found.used_vertices - found.different_vertices;
    const bool are_paired = made.topology->are_paired, is_one_part = made.is_one_part(),
               is_inside_out = made.encloses_negative_volume();
    kept_mesh =
        std::make_unique<engine::KeptMesh>(context(), pool, std::move(mesh), std::move(made), kept_options(options));
    SignSurface surface;
    if (are_paired) {
        kept_mesh->set_encloses_negative_volume(is_inside_out);
        describe_paired_edges(is_inside_out, topology);
        if (!is_one_part) describe_parts(kept_mesh->mesh(), kept_mesh->mesh().triangles(), topology);
    } else {  // edges have to be counted, so a good order of the faces is worth little
        surface = describe_edges(kept_mesh->mesh(), kept_mesh->mesh().triangles(), false, options.sign, topology);
    }
    set_sign(std::move(surface), options, call);
}

void DistanceTransform::State::set_sign(SignSurface surface, const TransformOptions& options, const CallOptions& call) {
    kept_points = std::make_unique<points::KeptPoints>(*kept_mesh);
    const ResolvedSignRule resolved = resolve_sign_rule(options.sign, topology);
    sign = resolved.rule;
    OpenLoops open_loops = std::move(surface.open_loops);
    if (sign == SignRule::below) open_loops.floor = floor = options.floor;
    if ((sign == SignRule::solid_angle || sign == SignRule::below) && !open_loops.empty())
        kept_mesh->set_open_loops(std::move(open_loops));
    surface.open_loops = {};
    if (sign != SignRule::none) kept_mesh->set_sign_surface(std::move(surface));
    if (!resolved.warning.empty() && call.log) call.log(resolved.warning);
}

template <class Make>
std::optional<engine::MadeTopology> DistanceTransform::State::make_topology(std::size_t vertex_count,
                                                                            std::size_t face_count,
                                                                            const CallOptions& call,
                                                                            const Make& make) const {
    const engine::DeviceSetUp set_up(tools(), engine::SetUpWays(tools(), vertex_count, face_count));
    if (method || !set_up.ways.topology_by_kernels) return std::nullopt;
    context().begin_call();
    calls::RunningCall running{call};
    test(checks::topology_subject(*this), running);
    try {
        return make(set_up);
    } catch (const Error& error) {
        // The host needs no memory of the device.
        if (error.code() != ErrorCode::out_of_memory) throw;
        return std::nullopt;
    }
}

DistanceTransform::State::State(const State& other, const std::shared_ptr<device::BufferPool>& own_pool,
                                std::unique_ptr<engine::KeptMesh> own_mesh)
    : engine::Workshop(other.with(own_pool)),
      topology(other.topology),
      floor(other.floor),
      failures(other.failures),
      kept_mesh(std::move(own_mesh)),
      kept_points(std::make_unique<points::KeptPoints>(*kept_mesh)) {}

std::unique_ptr<DistanceTransform::State> DistanceTransform::State::restricted(std::vector<Region> regions,
                                                                               double margin) {
    if (regions.empty()) refuse("a transform is restricted to regions, and there is none; give one");
    for (std::size_t n = 0; n < regions.size(); ++n) {
        const auto& [box, half_width, spacing] = regions[n];
        points::check_box(box, fmt::format("the box of region {} of {}", n, regions.size()));
        if (!(half_width > 0 && std::isfinite(half_width)))
            refuse(
                "region {} of {} has the half width {}, which must be positive and finite: "
                "give the largest one that is asked for; for fields without a band use the whole "
                "transform",
                n, regions.size(), half_width);
        if (!(spacing >= 0 && std::isfinite(spacing)))
            refuse(
                "region {} of {} has the spacing {}; give the largest one of its grids, or 0 if "
                "there are none",
                n, regions.size(), spacing);
    }
    if (!(margin >= 0 && std::isfinite(margin)))
        refuse("the margin is {}; give the longest way that a vertex will move, or 0 if they stay", margin);
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    if (kept_mesh->restriction() != nullptr)
        refuse_unsupported("the transform is restricted already; restrict the whole one");
    if (method)
        refuse_unsupported("a transform with polyhedra or a scan of clsdf::papers cannot be restricted; use the whole");
    context().begin_call();
    auto own_pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    auto own_mesh = calls::with_remedies(nullptr, {forgetting()}, [&] {
        return std::make_unique<engine::KeptMesh>(
            context(), own_pool, kept_mesh->part_of_regions(regions, sign, margin), kept_mesh->options());
    });
    return std::unique_ptr<State>(new State(*this, own_pool, std::move(own_mesh)));
}

std::unique_ptr<DistanceTransform::State> DistanceTransform::State::joined(engine::JoinedMeshes meshes,
                                                                           bool are_inside_out) const {
    auto own_pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    auto own_mesh = std::make_unique<engine::KeptMesh>(context(), own_pool, std::move(meshes.mesh),
                                                       std::move(meshes.topology), kept_mesh->options());
    own_mesh->set_given_faces({{}, std::move(meshes.numbers)});
    own_mesh->set_encloses_negative_volume(are_inside_out);
    return std::unique_ptr<State>(new State(*this, own_pool, std::move(own_mesh)));
}

void DistanceTransform::State::select_meshes(std::vector<std::uint32_t> meshes) {
    const std::scoped_lock lock(mutex);
    plans.clear();  // which are of others
    kept_mesh->select_meshes(std::move(meshes));
}

void DistanceTransform::State::move_joined(std::vector<Vec3> positions) {
    const std::scoped_lock lock(mutex);
    const bool are_inside_out = kept_mesh->encloses_negative_volume();
    move_vertices(std::move(positions));
    kept_mesh->set_encloses_negative_volume(are_inside_out);
}

std::vector<std::byte> DistanceTransform::State::part_bytes() {
    const std::scoped_lock lock(mutex);
    if (kept_mesh->restriction() == nullptr)
        refuse_unsupported("the transform is whole, and parts alone have bytes; restrict it first");
    const engine::RegionPart part = kept_mesh->own_part();
    if (part.given_faces)
        refuse_unsupported(
            "a part of a transform whose surface is outer has no bytes; make the transform of the mesh of outer()");
    return engine::bytes_of(part, {sign, floor, topology});
}

std::unique_ptr<DistanceTransform::State> DistanceTransform::State::of_part(Device device,
                                                                            std::span<const std::byte> bytes,
                                                                            const TransformOptions& options) {
    engine::StoredPart stored = engine::part_of_bytes(bytes);
    std::unique_ptr<State> state(new State(std::move(device), options, {}, nullptr));
    state->sign = stored.sign.sign;
    state->floor = stored.sign.floor;
    state->topology = std::move(stored.sign.topology);
    state->kept_mesh = std::make_unique<engine::KeptMesh>(state->context(), state->pool, std::move(stored.part),
                                                          state->kept_options(options));
    state->kept_points = std::make_unique<points::KeptPoints>(*state->kept_mesh);
    return state;
}

void DistanceTransform::State::set_positions(std::span<const Vec3> positions, const CallOptions& call) {
    const std::scoped_lock lock(mutex);
    require_mobile(true);
    if (kept_mesh->movable() != nullptr) {
        context().begin_call();
        move_by([&] {
            calls::with_remedies(nullptr, {forgetting()}, [&] { kept_mesh->move_part(positions); });
            return true;
        });
        return;
    }
    if (given) {
        const Mesh moved(given->vertices.moved(given->mesh, positions), given->mesh.triangles(), given->mesh.name());
        replace_outer([&] { set_outer(moved, given->options, {.should_stop = call.should_stop}); });
        given->has_moved = true;
        return;
    }
    if (move_by([&] { return kept_mesh->move_equal(positions); })) return;
    const engine::Vertices& vertices = kept_mesh->vertices();
    std::vector<Vec3> moved = vertices.moved(kept_mesh->mesh(), positions);
    check_joined(vertices, kept_mesh->mesh(), kept_mesh->sign_surface(), moved);
    move_vertices(std::move(moved));
}

void DistanceTransform::State::set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    const std::scoped_lock lock(mutex);
    require_mobile(false);
    if (given && given->has_moved) {
        replace_outer([&] {
            set_outer(given->mesh, given->options, {});
            kept_mesh->move(engine::Vertices::moved(kept_mesh->first_positions(), rotation, translation));
        });
        given->has_moved = false;
        return;
    }
    move_vertices(engine::Vertices::moved(kept_mesh->first_positions(), rotation, translation));
}

void DistanceTransform::State::require_mobile(bool is_movable) const {
    if (kept_mesh->restriction() == nullptr) return;
    if (kept_mesh->movable() == nullptr)
        refuse_unsupported(
            "the transform is restricted, and triangles would come and go; set the positions of the whole one and "
            "restrict it again, or restrict it with a margin");
    if (!is_movable)
        refuse_unsupported(
            "the transform is restricted, and the longest way of its vertices has a limit, the margin; set "
            "the positions of its vertices in the place of a motion");
}

void DistanceTransform::State::move_vertices(std::vector<Vec3> positions) {
    move_by([&] {
        kept_mesh->move(std::move(positions));
        return true;
    });
}

bool DistanceTransform::State::set_positions_on_device(const InputArray& positions) {
    const std::scoped_lock lock(mutex);
    require_mobile(true);
    if (given || kept_mesh->movable() != nullptr || !kernels_can_read(positions)) return false;
    context().begin_call();
    return move_by([&] { return kept_mesh->move(engine::device_triples(positions)); });
}

template <class Move>
bool DistanceTransform::State::move_by(const Move& move) {
    if (!move()) return false;
    points_asked = 0;
    points_are_short_of_memory = false;
    plans.clear();
    try {
        kept_mesh->keep_only_copies_within_budget();
    } catch (const std::exception&) {
        // The vertices have moved, and their positions stay on the device.
    }
    return true;
}

void DistanceTransform::State::test(std::span<const checks::TestSubject> subjects, calls::RunningCall& running) const {
    std::size_t steps = 0;
    for (const checks::TestSubject& subject : subjects)
        if (!context().is_tested(subject.name)) steps += subject.steps;
    for (const checks::TestSubject& subject : subjects)
        if (!context().is_tested(subject.name))
            running.compile(
                steps, [&](const device::BuildWatch& watch) { return checks::ensure_tested(device, subject, watch); });
}

engine::Job DistanceTransform::State::check(engine::JobKey asked) const {
    for (const double width : {asked.band.inside, asked.band.outside})
        if (width > 0 && static_cast<float>(width) == 0)
            refuse(
                "the band's half width {} is below the range of floats, in which distances are "
                "given; scale the mesh and the grid up",
                width);
    if (asked.band.has_signs_only && sign == SignRule::none)
        refuse(
            "a field of signs alone is asked for, and the transform has no sign; give the band a width, or "
            "make the transform of a closed mesh with a sign rule");
    if (asked.band.has_exact_signs && sign == SignRule::none)
        refuse(
            "exact signs of {} are asked for, and it has no sign; make the transform of a closed "
            "mesh with a sign rule, or leave exact signs out",
            kept_mesh->name());
    if (method) {
        method->check_outputs(asked.outputs);
        if (asked.band.has_exact_signs)
            refuse_unsupported(
                "exact signs are those of leaned frusta, scanned by bricks, alone; leave exact signs out, or "
                "the published method");
        if (asked.outputs.contains(Output::distance))
            refuse_unsupported(
                "distances in double are computed from leaned frusta, scanned by bricks, alone; give the "
                "distance an array of floats");
    }
    return kept_mesh->checked(std::move(asked), sign);
}

DistanceTransform::State::NormalsNeeded DistanceTransform::State::normals_for(OutputSet outputs) {
    if (!engine::takes_normals(outputs)) return {false, false};
    if (sign == SignRule::solid_angle && !topology.balanced) return {true, topology.inside_out};
    return {true, sign != SignRule::none && topology.balanced && kept_mesh->encloses_negative_volume()};
}

CallStatistics DistanceTransform::State::compute(std::span<const Request> requests, const CallOptions& call) {
    const bool on_device = !requests.empty() && targets::are_on_device(requests.front().targets);
    return on_device ? compute_on_device(requests, call) : compute_on_host(requests, call);
}

void DistanceTransform::State::compile(const engine::Job& job, calls::RunningCall& running,
                                       std::vector<checks::TestSubject> others) const {
    context().begin_call();
    std::vector<checks::TestSubject> subjects;
    for (const checks::FieldKernels kernels : checks::kernels_of(*this, job))
        subjects.push_back(checks::field_subject(*this, job, kernels));
    std::ranges::move(others, std::back_inserter(subjects));
    test(subjects, running);
}

std::unique_ptr<engine::GridPlan> DistanceTransform::State::take_plan(const engine::JobKey& asked) {
    const auto found =
        std::ranges::find(plans, asked, [](const auto& plan) -> const engine::JobKey& { return plan->job; });
    if (found == plans.end()) return nullptr;
    std::unique_ptr<engine::GridPlan> plan = std::move(*found);
    plans.erase(found);
    // The time of its set-up belongs to the call that made it.
    plan->statistics.lists_seconds = plan->statistics.sign_seconds = 0;
    return plan;
}

void DistanceTransform::State::keep(std::unique_ptr<engine::GridPlan> plan) {
    if (!method) plans.push_front(std::move(plan));
    plan.reset();
    if (plans.size() > most_plans) plans.pop_back();
}

std::size_t DistanceTransform::State::bytes_of(const engine::GridPlan& plan) const {
    return plan.own_bytes() + engine::bytes_beside(*kept_mesh, plan.inputs);
}

void DistanceTransform::State::keep_within_budget() {
    const std::size_t budget = kept_mesh->budget();
    const std::size_t lattices = kept_mesh->device_bytes();
    std::size_t bytes = lattices;
    std::erase_if(plans, [&](const auto& plan) {
        const std::size_t more = bytes_of(*plan);
        if (bytes + more > budget) return true;
        bytes += more;
        return false;
    });
    if (lattices > budget) kept_mesh->keep_within(budget);
}

bool DistanceTransform::State::forget() {
    const std::size_t plans_before = plans.size(), bytes_before = kept_mesh->device_bytes();
    plans.clear();
    kept_mesh->read_only_copies();
    kept_mesh->release();
    return pool->release() || plans_before > 0 || kept_mesh->device_bytes() < bytes_before;
}

}  // namespace clsdf

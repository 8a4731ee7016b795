#include "transform/transform_state.hpp"

#include "core/lifetime.hpp"
#include "core/stopwatch.hpp"
#include "points/box_places.hpp"
#include "scan/coarse_lists.hpp"
#include "scan/layout_of.hpp"
#include "scan/sweep_mesh.hpp"
#include "transform/field_method.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace clsdf {

namespace {

/// For the grids of a time step. More would keep the memory that the next one needs.
constexpr std::size_t most_plans = 4;

}  // namespace

bool DistanceTransform::State::KeptPlan::fits(const Grid& grid, const Band& band, OutputSet outputs,
                                              std::span<const Grid> wanted, bool counts) const {
    return plan->grid == grid && plan->band == band && plan->outputs == outputs && count == counts &&
           std::ranges::equal(plan->wanted, wanted);
}

DistanceTransform::State::State(Device device_in, Mesh mesh, const TransformOptions& options, const CallOptions& call,
                                std::shared_ptr<const FieldMethod> method_in)
    : device(std::move(device_in)),
      method(std::move(method_in)),
      topology(describe_topology(mesh)),
      vertices(mesh, topology.coincident_vertices > 0),
      programs(build_programs(options, call)),
      pool(std::make_shared<device::BufferPool>(device::shared_context_of(device))) {
    const ResolvedSignRule resolved = resolve_sign_rule(options.sign, topology);
    sign = resolved.rule;
    if (!resolved.warning.empty() && call.log) call.log(resolved.warning);
    stages = std::make_unique<transform::Stages>(
        device::context_of(device), pool, std::move(mesh),
        transform::Stages::Options{method, transform::SetUpBy{programs.mesh_records, programs.mesh_lanes()},
                                   programs.body == KernelBody::by_vector, options.kept_bytes});
}

DistanceTransform::State::State(const State& other, const std::shared_ptr<device::BufferPool>& own_pool,
                                std::unique_ptr<transform::Stages> own_stages)
    : device(other.device),
      method(other.method),
      topology(other.topology),
      sign(other.sign),
      vertices(other.vertices),
      programs(other.programs),
      pool(own_pool),
      stages(std::move(own_stages)) {}

std::unique_ptr<DistanceTransform::State> DistanceTransform::State::restricted(std::vector<Region> regions) {
    if (regions.empty())
        throw Error(ErrorCode::invalid_argument, "a transform is restricted to regions, and there is none; give one");
    for (std::size_t n = 0; n < regions.size(); ++n) {
        const auto& [box, half_width, spacing] = regions[n];
        try {
            points::check_boxes({&box, 1});
        } catch (const Error& error) {
            throw Error(error.code(), fmt::format("region {} of {}: {}", n, regions.size(), error.what()));
        }
        if (!(half_width > 0 && std::isfinite(half_width)))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("region {} of {} has the half width {}, which must be positive and finite; without "
                                    "an end every triangle can matter: use the whole transform",
                                    n, regions.size(), half_width));
        if (!(spacing >= 0 && std::isfinite(spacing)))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("region {} of {} has the spacing {}; give the largest one of its grids, or 0 if "
                                    "there are none",
                                    n, regions.size(), spacing));
    }
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    if (stages->restriction() != nullptr)
        throw Error(ErrorCode::unsupported, "the transform is restricted already; restrict the whole one");
    if (method)
        throw Error(ErrorCode::unsupported,
                    "a transform with polyhedra or a scan of clsdf::papers cannot be restricted; use the whole");
    auto own_pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    auto own_stages = make_room_for([&] { return stages->restricted(own_pool, regions, sign); });
    return std::unique_ptr<State>(new State(*this, own_pool, std::move(own_stages)));
}

DistanceTransform::State::~State() {
    if (device::context_of(device).is_lost()) keep_for_good(stages);  // the device reads its mesh in the host's memory
}

scan::Programs DistanceTransform::State::build_programs(const TransformOptions& options, const CallOptions& call) {
    transform::Caller caller(call);
    caller.throw_if_stopped();
    const Stopwatch watch;
    transform::TestCase any;
    any.method = method;
    transform::Compiling compiling(caller);
    scan::Programs result = device::guarded([&] {
        return scan::Programs(device::context_of(device), options.body, compiling.watch(transform::step_count(any)));
    });
    setup.compile_seconds = watch.seconds();
    setup.work = std::make_shared<const WorkCounts>();
    return result;
}

void DistanceTransform::State::set_positions(std::span<const Vec3> positions) {
    const std::scoped_lock lock(mutex);
    require_whole();
    move_vertices(vertices.moved(mesh(), positions));
}

void DistanceTransform::State::set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    const std::scoped_lock lock(mutex);
    require_whole();
    move_vertices(transform::Vertices::moved(first_positions.empty() ? mesh().vertices() : first_positions, rotation,
                                             translation));
}

void DistanceTransform::State::require_whole() const {
    if (stages->restriction() != nullptr)
        throw Error(ErrorCode::unsupported,
                    "the transform is restricted, and triangles would come and go; move the whole one and restrict it "
                    "again");
}

void DistanceTransform::State::move_vertices(std::vector<Vec3> positions) {
    std::vector<Vec3> before;
    if (first_positions.empty()) before = mesh().vertices();
    stages->move(std::move(positions));
    points_asked = 0;
    points_are_short_of_memory = false;
    if (first_positions.empty()) first_positions = std::move(before);
    plans.clear();
}

transform::TestCase DistanceTransform::State::test_case_of(const Grid& grid, const Band& band, OutputSet outputs,
                                                           bool count) const {
    const Layout layout = scan::layout_of(grid, band, sign);
    transform::TestCase test_case;
    test_case.body = programs.body;
    test_case.variant = {outputs != OutputSet{}, count, scan::has_long_bricks(grid)};
    test_case.is_signed = sign != SignRule::none;
    if (method)
        test_case.method =
            device::guarded([&] { return method->tested_as(device::context_of(device), layout, test_case.variant); });
    else
        test_case.is_wide = !scan::has_uniform_bounds(layout);
    return test_case;
}

bool DistanceTransform::State::test(const transform::TestCase& test_case, transform::Compiling& compiling) const {
    if (device::context_of(device).is_tested(test_case.name())) return false;
    const Stopwatch watch;
    const bool is_tested_here =
        transform::ensure_tested(device, programs, test_case, compiling.watch(transform::step_count(test_case)));
    compiling.first_use |= is_tested_here;
    compiling.seconds += watch.seconds();
    return is_tested_here;
}

void DistanceTransform::State::check(const Grid& grid, const Band& band, OutputSet outputs) const {
    if (method) {
        method->check_outputs(outputs);
        if (outputs.contains(Output::distance))
            throw Error(ErrorCode::unsupported,
                        "distances in double are computed from leaned frusta, scanned by bricks, alone; give the "
                        "distance an array of floats");
    }
    stages->check(grid, band, sign);
}

bool DistanceTransform::State::compile(const Grid& grid, const Band& band, OutputSet outputs, bool count,
                                       transform::Compiling& compiling) const {
    device::context_of(device).require_usable();
    transform::TestCase test_case = test_case_of(grid, band, outputs, count);
    transform::TestCase large = test_case;
    large.is_large = true;
    // It runs all that the other one runs.
    if (device::context_of(device).is_tested(large.name())) return false;
    return test(test_case.is_signed && scan::expects_large_triangles(grid, mesh()) ? large : test_case, compiling);
}

transform::Inputs DistanceTransform::State::inputs(const Grid& grid, const Band& band, OutputSet outputs, bool lone) {
    return make_room_for([&] { return make_inputs(grid, band, outputs, lone); });
}

transform::Inputs DistanceTransform::State::make_inputs(const Grid& grid, const Band& band, OutputSet outputs,
                                                        bool lone) {
    transform::Inputs inputs = stages->inputs(grid, scan::layout_of(grid, band, sign), sign, lone);
    if (outputs == OutputSet{} || method) return inputs;
    inputs.sites = stages->sites(transform::names_sites(outputs),
                                 outputs.contains(Output::gradient) && stages->may_meet_samples(grid));
    inputs.is_inside_out =
        outputs.contains(Output::gradient) && topology.balanced && stages->encloses_negative_volume();
    return inputs;
}

std::unique_ptr<transform::GridPlan> DistanceTransform::State::make_plan(
    transform::Inputs inputs, const Grid& grid, const Band& band, OutputSet outputs, std::span<const Grid> wanted,
    bool count, transform::Caller& caller, transform::Compiling& compiling, std::shared_ptr<device::BufferPool> from) {
    if (!from) from = pool;
    auto plan =
        std::make_unique<transform::GridPlan>(device, from, programs, std::move(inputs), grid, band, sign, outputs,
                                              transform::PlanOptions{count, method, {wanted.begin(), wanted.end()}},
                                              [&caller] { caller.throw_if_stopped(); });
    // Only the sweep sees whether triangles are large, and only the stages whether records are made of kept frusta.
    const bool is_later = plan->inputs.records->is_later;
    if (plan->has_large_triangles || is_later) {
        transform::TestCase found = test_case_of(grid, band, outputs, count);
        found.is_large = plan->has_large_triangles;
        found.is_later = is_later;
        try {
            test(found, compiling);
        } catch (...) {
            device::context_of(device).drain();  // the set-up's commands use the plan's buffers
            throw;
        }
    }
    from->trim();
    return plan;
}

std::unique_ptr<transform::GridPlan> DistanceTransform::State::take_plan(const Grid& grid, const Band& band,
                                                                         OutputSet outputs,
                                                                         std::span<const Grid> wanted, bool count) {
    const auto found = std::find_if(plans.begin(), plans.end(), [&](const KeptPlan& kept) {
        return kept.fits(grid, band, outputs, wanted, count);
    });
    if (found == plans.end()) return nullptr;
    std::unique_ptr<transform::GridPlan> plan = std::move(found->plan);
    plans.erase(found);
    // The time of its set-up belongs to the call that made it.
    plan->statistics.lists_seconds = plan->statistics.sign_seconds = 0;
    return plan;
}

void DistanceTransform::State::keep(std::unique_ptr<transform::GridPlan> plan, bool count) {
    if (!method) plans.push_front({count, std::move(plan)});
    plan.reset();
    if (plans.size() > most_plans) plans.pop_back();
}

std::size_t DistanceTransform::State::bytes_of(const transform::GridPlan& plan) const {
    return plan.own_bytes() + stages->bytes_beside(plan.inputs);
}

void DistanceTransform::State::keep_within_budget() {
    const std::size_t budget = stages->budget();
    const std::size_t lattices = stages->device_bytes();
    std::size_t bytes = lattices;
    for (auto kept = plans.begin(); kept != plans.end();) {
        const std::size_t more = bytes_of(*kept->plan);
        if (bytes + more > budget) {
            kept = plans.erase(kept);
        } else {
            bytes += more;
            ++kept;
        }
    }
    if (lattices > budget) stages->keep_within(budget);
}

bool DistanceTransform::State::forget() {
    const std::size_t plans_before = plans.size(), bytes_before = stages->device_bytes();
    plans.clear();
    stages->release();
    return pool->release() > 0 || plans_before > 0 || stages->device_bytes() < bytes_before;
}

}  // namespace clsdf

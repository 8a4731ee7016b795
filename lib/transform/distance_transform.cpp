#include <clsdf/distance_transform.hpp>

#include "core/keep.hpp"
#include "core/moved_from.hpp"
#include "core/parallel.hpp"
#include "core/per_output.hpp"
#include "core/stopwatch.hpp"
#include "transform/coarse_lists.hpp"
#include "transform/field_method.hpp"
#include "transform/layout_of.hpp"
#include "transform/output_targets.hpp"
#include "transform/plan_state.hpp"
#include "transform/programs.hpp"
#include "transform/requests.hpp"
#include "transform/self_test.hpp"
#include "transform/slab_pipeline.hpp"
#include "transform/slabs.hpp"
#include "transform/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <list>
#include <mutex>
#include <optional>
#include <utility>

namespace clsdf {

namespace {

void add(TransformStatistics& total, const TransformStatistics& slab) {
    total.triangles = slab.triangles;
    total.polyhedra = slab.polyhedra;
    total.box_polyhedra = slab.box_polyhedra;
    total.saddle_vertices = slab.saddle_vertices;
    total.point_sites = slab.point_sites;
    total.coarse_pairs += slab.coarse_pairs;
    total.coarse_bricks += slab.coarse_bricks;
    ++total.slabs;
    total.brick_pairs += slab.brick_pairs;
    total.lanes_evaluated += slab.lanes_evaluated;
    total.samples_covered += slab.samples_covered;
    total.band_samples += slab.band_samples;
    total.lists_seconds += slab.lists_seconds;
    total.sign_seconds += slab.sign_seconds;
    total.field_seconds += slab.field_seconds;
    total.bricks_seconds += slab.bricks_seconds;
    total.fill_seconds += slab.fill_seconds;
    for (const auto& [name, count] : slab.method_counts) {
        MethodCount& sum = total.method_counts[name];
        sum = {count.of_mesh ? count.value : sum.value + count.value, count.of_mesh};
    }
}

/// Of several calls, one after the other.
void add_call(TransformStatistics& total, const TransformStatistics& call) {
    const std::size_t slabs = total.slabs + call.slabs;
    add(total, call);
    total.slabs = slabs;
    total.polyhedra_seconds += call.polyhedra_seconds;
    total.compile_seconds += call.compile_seconds;
    total.first_use |= call.first_use;
    total.device_bytes = std::max(total.device_bytes, call.device_bytes);
    total.host_bytes = std::max(total.host_bytes, call.host_bytes);
}

void throw_if_stopped(const CallOptions& call) {
    if (call.should_stop && call.should_stop()) throw Error(ErrorCode::cancelled, "the computation was cancelled");
}

void check_rotation(const std::array<Vec3, 3>& rotation) {
    const auto product = [&](std::size_t a, std::size_t b) {
        return rotation[a][0] * rotation[b][0] + rotation[a][1] * rotation[b][1] + rotation[a][2] * rotation[b][2];
    };
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = a; b < 3; ++b)
            if (const double expected = a == b ? 1 : 0; !(std::abs(product(a, b) - expected) <= 1e-12))
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("the rotation is none: the product of its rows {} and {} is {}, and must be {} "
                                        "to 1e-12; make its rows unit vectors at right angles",
                                        a, b, product(a, b), expected));
    const auto& [x, y, z] = rotation;
    const double determinant =
        x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
    if (determinant < 0)
        throw Error(ErrorCode::invalid_argument,
                    "the rotation is a reflection, whose determinant is -1; it would turn the mesh inside out");
}

/// The building, loading and testing of programs by one call.
class Compiling {
public:
    Compiling(const CallOptions& call, const std::function<void(const std::string&)>& log) : call_(call), log_(log) {}

    /// `variant_steps`: those of building beside the programs that all computations need.
    device::BuildWatch watch(std::size_t variant_steps) {
        const std::size_t most = transform::Programs::common_programs + variant_steps;
        const auto step = [this, most](bool is_waiting) {
            throw_if_stopped(call_);
            const std::size_t steps = std::max(most, step_);
            if (call_.compiling) call_.compiling({std::max<std::size_t>(step_, 1), steps, is_waiting});
        };
        return {[this, step] {
                    ++step_;
                    step(false);
                },
                [step] { step(true); }, log_};
    }

    double seconds = 0;
    bool first_use = false;

private:
    const CallOptions& call_;
    const std::function<void(const std::string&)>& log_;
    std::size_t step_ = 0;
};

}  // namespace

struct DistanceTransform::State {
    /// A plan of an earlier call, which the next call of the same kind takes.
    struct KeptPlan {
        bool count;
        std::unique_ptr<Plan::State> plan;

        bool fits(const Grid& grid, const Band& band, const Outputs& outputs, bool counts) const {
            return plan->grid == grid && plan->band.inside == band.inside && plan->band.outside == band.outside &&
                   plan->outputs == outputs && count == counts;
        }
    };

    // What was spent on programs and no computation has reported yet.
    double compile_seconds = 0;
    bool first_use = false;
    Device device;
    TransformOptions options;
    Topology topology;
    SignRule sign = SignRule::none;
    std::size_t vertex_count = 0;       // of the caller's mesh
    std::vector<std::uint32_t> welded;  // of each of them its index here, or no_vertex; empty if they are the same
    transform::Programs programs;
    std::shared_ptr<device::BufferPool> pool;

    std::mutex mutex;  // for what follows, and for the work on the device
    std::unique_ptr<transform::Stages> stages;
    std::list<KeptPlan> plans;          // that was used last first
    std::vector<Vec3> first_positions;  // of the transform's mesh, from the first move on

    static constexpr std::uint32_t no_vertex = 0xFFFFFFFFU;
    /// For the grids of a time step. More would keep the memory that the next one needs.
    static constexpr std::size_t most_plans = 4;

    State(Device device_in, Mesh mesh, TransformOptions options_in, const CallOptions& call)
        : device(std::move(device_in)),
          options(std::move(options_in)),
          topology(describe_topology(mesh)),
          vertex_count(mesh.vertices().size()),
          programs(build_programs(call)),
          pool(std::make_shared<device::BufferPool>(device.shared())) {
        // Edges between vertices that are equal but not one would be open ones: exact, but slow.
        if (topology.coincident_vertices > 0) {
            Mesh one_of_each = weld(mesh);
            welded.assign(vertex_count, no_vertex);
            for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
                for (std::size_t k = 0; k < 3; ++k) welded[mesh.triangles()[t][k]] = one_of_each.triangles()[t][k];
            mesh = std::move(one_of_each);
        }
        const ResolvedSignRule resolved = resolve_sign_rule(options.sign, topology);
        sign = resolved.rule;
        if (!resolved.warning.empty() && options.log) options.log(resolved.warning);
        stages = std::make_unique<transform::Stages>(device.internal(), pool, std::move(mesh), options.method);
    }

    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (device.internal().is_lost()) keep_for_good(stages);  // whose mesh the device reads where the host has it
    }

    const Mesh& mesh() const { return stages->mesh(); }

    transform::Programs build_programs(const CallOptions& call) {
        throw_if_stopped(call);
        const Stopwatch watch;
        transform::TestCase any;
        any.method = options.method;
        Compiling compiling(call, options.log);
        transform::Programs result = device::guarded([&] {
            return transform::Programs(device.internal(), options.body, compiling.watch(transform::step_count(any)));
        });
        compile_seconds = watch.seconds();
        return result;
    }

    void move(std::span<const Vec3> positions) {
        if (positions.size() != vertex_count)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("{} has {} vertices, and {} positions are given to move them to; give one for each",
                                    mesh().name(), vertex_count, positions.size()));
        const std::scoped_lock lock(mutex);
        move_vertices(welded.empty() ? std::vector<Vec3>(positions.begin(), positions.end())
                                     : positions_of_welded(positions));
    }

    void move(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
        check_rotation(rotation);
        const std::scoped_lock lock(mutex);
        std::vector<Vec3> positions = first_positions.empty() ? mesh().vertices() : first_positions;
        for_each_index(positions.size(), [&](std::size_t vertex) {
            const Vec3 x = positions[vertex];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const Vec3& row = rotation[axis];
                positions[vertex][axis] =
                    std::fma(row[0], x[0], std::fma(row[1], x[1], std::fma(row[2], x[2], translation[axis])));
            }
        });
        move_vertices(std::move(positions));
    }

    /// Of the transform's own mesh.
    void move_vertices(std::vector<Vec3> positions) {
        std::vector<Vec3> before;
        if (first_positions.empty()) before = mesh().vertices();
        stages->move(std::move(positions));
        if (first_positions.empty()) first_positions = std::move(before);
        plans.clear();
    }

    /// Throws if vertices that were one move apart.
    std::vector<Vec3> positions_of_welded(std::span<const Vec3> positions) const {
        std::vector<Vec3> result(mesh().vertices());
        std::vector<std::uint32_t> first(result.size(), no_vertex);
        for (std::uint32_t vertex = 0; vertex < vertex_count; ++vertex) {
            const std::uint32_t index = welded[vertex];
            if (index == no_vertex) continue;
            const Vec3& to = positions[vertex];
            if (first[index] == no_vertex) {
                first[index] = vertex;
                result[index] = to;
            } else if (const Vec3& other = result[index]; other != to) {
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("vertices {} and {} of {} had equal coordinates and count as one, and they "
                                        "move apart, to ({}, {}, {}) and ({}, {}, {}); move them together, or make "
                                        "a new transform",
                                        first[index], vertex, mesh().name(), other[0], other[1], other[2], to[0], to[1],
                                        to[2]));
            }
        }
        return result;
    }

    transform::TestCase test_case_of(const Grid& grid, const Band& band, const Outputs& outputs, bool count) const;
    /// Builds and tests, the first time, what such a computation runs on the device.
    bool compile(const Grid& grid, const Band& band, const Outputs& outputs, bool count, Compiling& compiling) const;
    bool test(const transform::TestCase& test_case, Compiling& compiling) const;

    void report(const Compiling& compiling, TransformStatistics& statistics) {
        statistics.compile_seconds = compiling.seconds + std::exchange(compile_seconds, 0);
        statistics.first_use = std::exchange(first_use, false) || compiling.first_use;
    }

    transform::Inputs inputs(const Grid& grid, const Band& band, const Outputs& outputs) {
        try {
            return make_inputs(grid, band, outputs);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::out_of_memory || !forget()) throw;
        }
        return make_inputs(grid, band, outputs);
    }

    transform::Inputs make_inputs(const Grid& grid, const Band& band, const Outputs& outputs) {
        transform::Inputs inputs = stages->inputs(grid, transform::layout_of(grid, band, sign), sign);
        if (outputs == Outputs{} || options.method) return inputs;
        inputs.sites = stages->sites(outputs.gradient);
        inputs.is_inside_out = topology.balanced && inputs.sites->encloses_negative_volume;
        return inputs;
    }

    std::unique_ptr<Plan::State> make_plan(transform::Inputs inputs, const Grid& grid, const Band& band,
                                           const Outputs& outputs, const CallOptions& call, Compiling& compiling) {
        auto plan =
            std::make_unique<Plan::State>(device, pool, programs, std::move(inputs), grid, band, sign, outputs,
                                          PlanOptions{call.count, options.method}, [&call] { throw_if_stopped(call); });
        // Only the sweep sees whether triangles are large.
        if (plan->has_large_triangles) {
            transform::TestCase large = test_case_of(grid, band, outputs, call.count);
            large.is_large = true;
            test(large, compiling);
        }
        pool->trim();
        return plan;
    }

    /// The plan of an earlier call like this one, which is the caller's now; null if none is kept.
    std::unique_ptr<Plan::State> take_plan(const Grid& grid, const Band& band, const Outputs& outputs, bool count) {
        const auto found = std::find_if(plans.begin(), plans.end(),
                                        [&](const KeptPlan& kept) { return kept.fits(grid, band, outputs, count); });
        if (found == plans.end()) return nullptr;
        std::unique_ptr<Plan::State> plan = std::move(found->plan);
        plans.erase(found);
        // What its set-up took belongs to the call that made it.
        plan->statistics.lists_seconds = plan->statistics.sign_seconds = 0;
        return plan;
    }

    /// Keeps a plan for the next call, and what it and others are made of, within the budget.
    void keep(std::unique_ptr<Plan::State> plan, bool count) {
        if (!options.method) plans.push_front({count, std::move(plan)});
        plan.reset();
        if (plans.size() > most_plans) plans.pop_back();
        const std::size_t budget =
            options.kept_bytes.value_or(std::max(2 * stages->record_bytes(), std::size_t{1} << 28));
        const std::size_t lattices = stages->device_bytes();
        std::size_t bytes = lattices;
        for (auto kept = plans.begin(); kept != plans.end();) {
            bytes += kept->plan->own_bytes();
            kept = bytes > budget ? plans.erase(kept) : std::next(kept);
        }
        if (lattices > budget) stages->keep_within(budget);
    }

    /// Releases what is kept for later calls. Returns whether there was something.
    bool forget() {
        const bool is_kept = !plans.empty() || stages->device_bytes() > 0;
        plans.clear();
        stages->keep_within(0);
        pool->release();
        return is_kept;
    }

    /// Slab by slab, into the arrays or, if not in place, to the sink.
    void compute(const Grid& grid, const Band& band, const Outputs& outputs, const transform::HostArrays& arrays,
                 bool in_place, std::vector<Grid> slabs, transform::SlabPipeline& pipeline, const CallOptions& call);

    /// Into packed arrays or, if some have strides, by way of slabs.
    void compute(const Grid& grid, const Band& band, const Outputs& outputs, const transform::HostTargets& targets,
                 const CallOptions& call);

    /// The block of a batch, slab by slab, of which each request takes its own.
    void compute(const transform::Batch& batch, std::span<const Request> requests,
                 std::span<const transform::HostTargets> targets, const CallOptions& call);

    /// The samples of one slab. Its progress runs from `begin` to `end`.
    void compute(Plan::State& plan, const transform::SlabPipeline::Slot& slot, double begin, double end,
                 const CallOptions& call) const;
};

void DistanceTransform::State::compute(Plan::State& plan, const transform::SlabPipeline::Slot& slot, double begin,
                                       double end, const CallOptions& call) const {
    const Stopwatch watch;
    const device::Context& context = device.internal();
    device::guarded([&] {
        std::function<void(double)> between;
        if (call.progress || call.should_stop)
            between = [&](double fraction) {
                throw_if_stopped(call);
                if (call.progress) call.progress(begin + (end - begin) * fraction);
            };
        try {
            plan.enqueue(context.queue(), slot.buffers(), {}, between);
            slot.enqueue_handover(context.queue());
            context.queue().finish();
            plan.read_counters();
            plan.read_times(context.queue());
        } catch (...) {
            // What is under way still writes to the caller's memory.
            context.drain();
            throw;
        }
    });
    plan.statistics.field_seconds = watch.seconds();
}

transform::TestCase DistanceTransform::State::test_case_of(const Grid& grid, const Band& band, const Outputs& outputs,
                                                           bool count) const {
    const Layout layout = transform::layout_of(grid, band, sign);
    transform::TestCase test_case;
    test_case.body = programs.body;
    test_case.variant = {outputs != Outputs{}, count, transform::has_long_bricks(grid)};
    test_case.is_signed = sign != SignRule::none;
    if (options.method)
        test_case.method =
            device::guarded([&] { return options.method->tested_as(device.internal(), layout, test_case.variant); });
    else
        test_case.is_wide = !transform::has_uniform_caps(layout);
    return test_case;
}

bool DistanceTransform::State::test(const transform::TestCase& test_case, Compiling& compiling) const {
    if (device.internal().is_tested(test_case.name())) return false;
    const Stopwatch watch;
    const bool is_tested_here =
        transform::ensure_tested(device, programs, test_case, compiling.watch(transform::step_count(test_case)));
    compiling.first_use |= is_tested_here;
    compiling.seconds += watch.seconds();
    return is_tested_here;
}

bool DistanceTransform::State::compile(const Grid& grid, const Band& band, const Outputs& outputs, bool count,
                                       Compiling& compiling) const {
    if (options.method) options.method->check_outputs(outputs);
    transform::TestCase test_case = test_case_of(grid, band, outputs, count);
    transform::TestCase large = test_case;
    large.is_large = true;
    // It runs all that the other one runs.
    if (device.internal().is_tested(large.name())) return false;
    return test(test_case.is_signed && transform::expects_large_triangles(grid, mesh()) ? large : test_case, compiling);
}

void DistanceTransform::State::compute(const Grid& grid, const Band& band, const Outputs& outputs,
                                       const transform::HostArrays& arrays, bool in_place, std::vector<Grid> slabs,
                                       transform::SlabPipeline& pipeline, const CallOptions& call) {
    TransformStatistics statistics;
    Compiling compiling(call, options.log);
    std::unique_ptr<Plan::State> plan;
    transform::Inputs inputs_of_grid;
    const auto set_inputs = [&] {
        const Stopwatch watch;
        inputs_of_grid = inputs(grid, band, outputs);
        statistics.polyhedra_seconds = watch.seconds();
        throw_if_stopped(call);
    };
    {
        const std::scoped_lock lock(mutex);
        throw_if_stopped(call);
        compile(grid, band, outputs, call.count, compiling);
        pool->restart_peak();
        if (slabs.size() == 1) plan = take_plan(grid, band, outputs, call.count);
        if (!plan) set_inputs();
    }
    const auto samples = static_cast<double>(grid.sample_count());
    std::reverse(slabs.begin(), slabs.end());
    for (std::size_t done = 0; !slabs.empty();) {
        const Grid slab = slabs.back();
        slabs.pop_back();
        const std::size_t count = slab.sample_count();
        transform::SlabPipeline::Slot& slot = pipeline.next();
        try {
            const std::scoped_lock lock(mutex);
            if (in_place) {
                transform::HostArrays part;
                for_each_output([&](const OutputRow& row, const auto& array,
                                    auto& of_slab) { of_slab = array.from_sample(row, done); },
                                arrays, part);
                pipeline.place(slot, slab, part);
            } else {
                pipeline.place_own(slot, slab, arrays);
            }
            if (!plan) plan = make_plan(inputs_of_grid, slab, band, outputs, call, compiling);
            throw_if_stopped(call);
            compute(*plan, slot, static_cast<double>(done) / samples, static_cast<double>(done + count) / samples,
                    call);
            add(statistics, plan->statistics);
            if (count < grid.sample_count()) plan.reset();
        } catch (const Error& error) {
            // How long a slab's lists are is known when they are made.
            if (error.code() != ErrorCode::out_of_memory || !transform::is_divisible(slab)) throw;
            const std::scoped_lock lock(mutex);
            const auto [lower, upper] = transform::halves_of(slab);
            slabs.push_back(upper);
            slabs.push_back(lower);
            // What is under way keeps its buffers.
            device::guarded([&] { device.internal().queue().finish(); });
            pipeline.take_back(slot);
            plan.reset();
            forget();
            if (!inputs_of_grid.records) set_inputs();
            continue;
        }
        pipeline.deliver(slot, slab);
        done += count;
    }
    pipeline.finish();
    {
        const std::scoped_lock lock(mutex);
        report(compiling, statistics);
        statistics.device_bytes = pool->peak();
        statistics.host_bytes = pipeline.host_bytes();
        inputs_of_grid = {};
        if (plan) keep(std::move(plan), call.count);
    }
    if (call.progress) call.progress(1.0);
    if (call.statistics != nullptr) *call.statistics = statistics;
}

DistanceTransform::DistanceTransform(Device device, const Mesh& mesh, TransformOptions options, const CallOptions& call)
    : state_(std::make_unique<State>(std::move(device), mesh, std::move(options), call)) {}
DistanceTransform::DistanceTransform(Device device, const MeshView& mesh, TransformOptions options,
                                     const CallOptions& call)
    : state_(std::make_unique<State>(std::move(device), Mesh(mesh), std::move(options), call)) {}
DistanceTransform::DistanceTransform(DistanceTransform&&) noexcept = default;
DistanceTransform& DistanceTransform::operator=(DistanceTransform&&) noexcept = default;
DistanceTransform::~DistanceTransform() = default;

DistanceTransform::State& DistanceTransform::state() const {
    return held_by(state_, "DistanceTransform");
}

const Topology& DistanceTransform::topology() const {
    return state().topology;
}
SignRule DistanceTransform::sign() const {
    return state().sign;
}
void DistanceTransform::move(std::span<const Vec3> positions) {
    state().move(positions);
}
void DistanceTransform::move(const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    state().move(rotation, translation);
}

KeptMemory DistanceTransform::memory() const {
    State& state = this->state();
    const std::scoped_lock lock(state.mutex);
    KeptMemory memory{state.stages->host_bytes() + state.first_positions.size() * sizeof(Vec3),
                      state.stages->device_bytes()};
    for (const State::KeptPlan& kept : state.plans) memory.device_bytes += kept.plan->own_bytes();
    return memory;
}

bool DistanceTransform::compile(const Grid& grid, const Band& band, const Outputs& outputs,
                                const CallOptions& call) const {
    State& state = this->state();
    throw_if_stopped(call);
    const std::scoped_lock lock(state.mutex);
    Compiling compiling(call, state.options.log);
    const bool is_tested = state.compile(grid, band, outputs, call.count, compiling);
    state.compile_seconds += compiling.seconds;
    state.first_use |= compiling.first_use;
    return is_tested;
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, const Outputs& outputs,
                             const CallOptions& call) const {
    State& state = this->state();
    const std::scoped_lock lock(state.mutex);
    Compiling compiling(call, state.options.log);
    state.compile(grid, band, outputs, call.count, compiling);
    const Stopwatch watch;
    transform::Inputs inputs = state.inputs(grid, band, outputs);
    const double seconds = watch.seconds();
    auto made = state.make_plan(std::move(inputs), grid, band, outputs, call, compiling);
    made->statistics.polyhedra_seconds = seconds;
    state.report(compiling, made->statistics);
    if (call.statistics != nullptr) *call.statistics = made->statistics;
    Plan plan(std::move(made));
    device::guarded(
        [&] { state.device.internal().queue().finish(); });  // errors of the set-up's commands are thrown here
    return plan;
}

void DistanceTransform::State::compute(const Grid& grid, const Band& band, const Outputs& outputs,
                                       const transform::HostTargets& targets, const CallOptions& call) {
    const device::Context& context = device.internal();
    const bool in_place = targets.are_packed();
    const auto store = [&](const Grid& part, const transform::HostArrays& values) { targets.store(part, values); };
    transform::SlabPipeline pipeline(context, pool, in_place ? transform::ArraySink() : transform::ArraySink(store),
                                     true);
    const transform::SlabLimits limits =
        in_place ? transform::limits_of(context.capabilities()) : transform::stream_limits_of(context.capabilities());
    compute(grid, band, outputs, targets.arrays(), in_place, transform::slabs_of(grid, limits), pipeline, call);
}

void DistanceTransform::State::compute(const transform::Batch& batch, std::span<const Request> requests,
                                       std::span<const transform::HostTargets> targets, const CallOptions& call) {
    const std::size_t any = batch.requests.front();
    const Request& request = requests[any];
    const Outputs outputs = transform::outputs_of(request.targets);
    if (batch.requests.size() == 1) {
        compute(request.grid, request.band, outputs, targets[any], call);
        return;
    }
    const device::Context& context = device.internal();
    const auto store = [&](const Grid& part, const transform::HostArrays& values) {
        constexpr std::size_t stretch = 8;
        for_each_stretch(batch.requests.size(), stretch, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) targets[batch.requests[n]].store(part, values);
        });
    };
    transform::SlabPipeline pipeline(context, pool, store, true);
    compute(batch.block, request.band, outputs, targets[any].arrays(), false,
            transform::slabs_of(batch.block, transform::stream_limits_of(context.capabilities())), pipeline, call);
}

void DistanceTransform::compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                const CallOptions& call) const {
    grid.validate();
    state().compute(grid, band, transform::outputs_of(targets), transform::HostTargets(targets, grid), call);
}

void DistanceTransform::compute(std::span<const Request> requests, const CallOptions& call) const {
    State& state = this->state();
    const std::vector<transform::HostTargets> targets = transform::targets_of(requests);
    const std::vector<transform::Batch> batches = transform::batches_of(requests, targets, state.mesh().box());
    double cost = 0, done = 0;
    for (const transform::Batch& batch : batches) cost += batch.cost;
    TransformStatistics total;
    for (const transform::Batch& batch : batches) {
        TransformStatistics statistics;
        CallOptions of_batch = call;
        of_batch.statistics = &statistics;
        if (call.progress)
            of_batch.progress = [&](double fraction) { call.progress((done + batch.cost * fraction) / cost); };
        state.compute(batch, requests, targets, of_batch);
        add_call(total, statistics);
        done += batch.cost;
    }
    if (call.statistics != nullptr) *call.statistics = total;
}

void DistanceTransform::compute_slabs(const Grid& grid, const Band& band, const Outputs& outputs, const SlabSink& sink,
                                      const SlabOptions& options, const CallOptions& call) const {
    State& state = this->state();
    grid.validate();
    grid.sample_count();
    if (!sink) throw Error(ErrorCode::invalid_argument, "DistanceTransform::compute_slabs needs a sink; it is empty");
    const device::Context& context = state.device.internal();
    const auto hand_on = [&](const Grid& part, const transform::HostArrays& values) {
        sink(part, transform::slab_of(values, part.sample_count()));
    };
    transform::SlabPipeline pipeline(context, state.pool, hand_on, options.overlap);
    state.compute(grid, band, outputs, transform::arrays_for(outputs), false,
                  transform::slabs_of(grid, transform::stream_limits_of(context.capabilities())), pipeline, call);
}

std::vector<Grid> DistanceTransform::slabs_of(const Grid& grid) {
    grid.validate();
    device::Context::Capabilities unlimited;
    unlimited.memory = unlimited.largest_allocation = std::numeric_limits<std::size_t>::max();
    return transform::slabs_of(grid, transform::stream_limits_of(unlimited));
}

Field DistanceTransform::operator()(const Grid& grid, const Band& band, const Outputs& outputs,
                                    const CallOptions& call) const {
    Field field;
    field.grid = grid;
    field.band = band;
    field.sign = sign();
    field.mesh_name = state().mesh().name();
    grid.validate();
    OutputTargets targets;
    try {
        field.distance.resize(grid.sample_count());
        targets.distance = field.distance;
        for_each_extra(
            [&](const OutputRow& row, bool wanted, auto& array, OutputTarget& target) {
                if (!wanted) return;
                array.resize(grid.sample_count() * row.components);
                target = array;
            },
            outputs, field, targets);
    } catch (const std::exception&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("a field of {} x {} x {} samples does not fit the memory; compute parts of the grid",
                                grid.size[0], grid.size[1], grid.size[2]));
    }
    try {
        compute(grid, band, targets, call);
    } catch (const Error&) {
        if (state_->device.internal().is_lost()) keep_for_good(field);
        throw;
    }
    return field;
}

}  // namespace clsdf

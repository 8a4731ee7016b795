#include "calls/point_plans.hpp"

#include "calls/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "core/outputs.hpp"
#include "core/stopwatch.hpp"
#include "mesh/input_arrays.hpp"
#include "mesh/triples.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/target_layout.hpp"
#include "targets/target_overlap.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace clsdf {

namespace calls {

namespace {

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, what};
}

/// Items of an array in a buffer: where the first one lies, and how they follow one another.
struct Items {
    cl_mem memory;
    std::ptrdiff_t first, stride;  ///< bytes
    std::ptrdiff_t begin, end;     ///< of the values of an item, from its first one
    std::size_t count;
};

Items items_of(cl_mem memory, std::size_t offset, std::ptrdiff_t stride, std::ptrdiff_t component_stride,
               std::size_t components, std::size_t width, std::size_t count) {
    const targets::BufferPlace place = targets::place_of(memory, offset);
    const std::ptrdiff_t last = component_stride * (static_cast<std::ptrdiff_t>(components) - 1);
    return {place.memory(),
            static_cast<std::ptrdiff_t>(place.byte),
            stride,
            std::min<std::ptrdiff_t>(last, 0),
            std::max<std::ptrdiff_t>(last, 0) + static_cast<std::ptrdiff_t>(width),
            count};
}

Items items_of(const InputArray& points) {
    const Steps steps = steps_of(points);
    return items_of(points.device, points.offset, steps.triple, steps.number, 3, bytes_of(points.type), points.count);
}

/// Whether they may have a byte in common: not if the bytes of the one all lie before those of the other, nor if those
/// of each item lie between items of the other, at the same stride.
bool may_overlap(const Items& a, const Items& b) {
    if (a.memory != b.memory || a.count == 0 || b.count == 0) return false;
    const auto range = [](const Items& items) {
        const std::ptrdiff_t last = items.first + items.stride * (static_cast<std::ptrdiff_t>(items.count) - 1);
        return std::pair(std::min(items.first, last) + items.begin, std::max(items.first, last) + items.end);
    };
    const auto [begin, end] = range(a);
    const auto [other_begin, other_end] = range(b);
    if (end <= other_begin || other_end <= begin) return false;
    if (a.stride != b.stride || a.stride <= 0) return true;
    // From the first value of an item of a to that of b's item behind it.
    std::ptrdiff_t ahead = (b.first + b.begin - (a.first + a.begin)) % a.stride;
    if (ahead < 0) ahead += a.stride;
    return ahead < a.end - a.begin || ahead + (b.end - b.begin) > a.stride;
}

Items items_of(const OutputInfo& row, const OutputArray& target, std::size_t count) {
    return items_of(target.device, target.offset, target.strides[0], target.component_stride, row.components,
                    bytes_of(target.type), count);
}

/// The status of each point.
OutputArray checked_status(const device::Context& context, const OutputArray& given, std::size_t count) {
    OutputArray status = given;
    if (status.host != nullptr)
        throw Error(ErrorCode::unsupported,
                    "the status of points goes to memory of the host, and a plan writes to the device's; give it a "
                    "buffer of the device");
    if (status.type != ElementType::automatic && status.type != ElementType::uint8)
        throw Error(ErrorCode::unsupported,
                    fmt::format("the status of points cannot be written as {}; give it an array of type {}",
                                name_of(status.type), name_of(ElementType::uint8)));
    status.type = ElementType::uint8;
    if (status.strides[0] == 0) status.strides[0] = 1;
    status.component_stride = 1;
    const cl::Buffer memory(status.device, true);
    targets::require_buffer(context, memory, "the memory of the status of points");
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_READ_ONLY) != 0)
        throw misuse(
            "the status of points is a buffer made with CL_MEM_READ_ONLY; kernels write to it, so make it "
            "with CL_MEM_READ_WRITE");
    const auto first = static_cast<std::ptrdiff_t>(status.offset);
    const std::ptrdiff_t last = first + status.strides[0] * (static_cast<std::ptrdiff_t>(count) - 1);
    const auto bytes = static_cast<std::ptrdiff_t>(memory.getInfo<CL_MEM_SIZE>());
    if (last < 0 || std::max(first, last) >= bytes)
        throw misuse(
            fmt::format("the status of {} points reaches from byte {} to {}, and its memory holds {}; give a "
                        "byte for each",
                        count, first, last, bytes));
    return status;
}

}  // namespace

void check_half_width(double half_width) {
    if (!(half_width >= 0))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("points are looked up within the half width {}, which must be 0 or more; infinity is "
                                "no limit",
                                half_width));
    if (std::isfinite(half_width) && half_width > static_cast<double>(std::numeric_limits<float>::max()))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("points are looked up within the half width {}, which is beyond the floats that "
                                "distances are given in; infinity is no limit",
                                half_width));
}

void check_device_points(const device::Context& context, const InputArray& points) {
    if (points.device == nullptr)
        throw Error(ErrorCode::unsupported,
                    "the points are memory of the host, and a plan reads the device's; give it a buffer of the device, "
                    "or ask with query()");
    const cl::Buffer memory(points.device, true);
    targets::require_buffer(context, memory, "the memory of the points");
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_WRITE_ONLY) != 0)
        throw misuse(
            "the points are a buffer made with CL_MEM_WRITE_ONLY; kernels read it, so make it with "
            "CL_MEM_READ_WRITE or CL_MEM_READ_ONLY");
    range_of(points, memory.getInfo<CL_MEM_SIZE>(), "points", ErrorCode::invalid_argument);
}

bool may_overlap(const InputArray& points, const targets::DeviceTargets& targets) {
    const Items of_points = items_of(points);
    bool result = false;
    for_each_output(
        [&](const OutputInfo& row, const OutputArray& target) {
            if (target.device != nullptr)
                result = result || may_overlap(of_points, items_of(row, target, points.count));
        },
        targets.targets);
    return result;
}

PointPlanState::~PointPlanState() {
    if (runs_.wait() == CL_SUCCESS) return;
    // Commands may still use them.
    keep_for_good(inputs);
    keep_for_good(run);
    keep_for_good(packed);
}

void PointPlanState::wait() {
    device::guarded([&] {
        if (const cl_int code = runs_.wait(); code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
    });
}

targets::DeviceTargets PointPlanState::check(const InputArray& points, const OutputTargets& targets,
                                             const OutputArray& status) const {
    check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
    if (points.count > count)
        throw misuse(
            fmt::format("the plan is for at most {} points at a time, and {} are given; give it parts of them, "
                        "or make a plan for more",
                        count, points.count));
    for (const auto& [output, array] : targets.all())
        if (array.strides[1] != 0 || array.strides[2] != 0)
            throw misuse(
                fmt::format("the array of the output {} has the strides ({}, {}, {}); points lie in one row: "
                            "set strides[0] alone",
                            info_of(output).name, array.strides[0], array.strides[1], array.strides[2]));
    OutputSet given = targets.outputs();
    for (const OutputInfo& row : output_table()) {
        if (given.contains(row.output) == outputs.contains(row.output)) continue;
        throw misuse(outputs.contains(row.output)
                         ? fmt::format("the plan computes the output {0}, and {0} has no target; give it memory, or "
                                       "plan without",
                                       row.name)
                         : fmt::format("the output {0} has a target, and the plan was made without; leave the target "
                                       "out, or make the plan with {0}",
                                       row.name));
    }
    targets::DeviceTargets checked(targets::targets_from(targets, 0), targets::row_of(points.count), context());
    std::vector<targets::WrittenArray> written;
    checked.add_written(0, written);
    targets::refuse_overlap(written);
    check_device_points(context(), points);
    if (may_overlap(points, checked))
        throw misuse(
            "a target of points may lie on the points, which are read while results are written; give the results "
            "other memory");
    if (!status.is_given()) return checked;
    const Items of_status = items_of(status.device, status.offset, status.strides[0], 1, 1, 1, points.count);
    bool overlaps = may_overlap(items_of(points), of_status);
    for_each_output(
        [&](const OutputInfo& row, const OutputArray& target) {
            if (target.device != nullptr)
                overlaps = overlaps || may_overlap(items_of(row, target, points.count), of_status);
        },
        checked.targets);
    if (overlaps) throw misuse("the status of points may lie on the points or on a target; give it other memory");
    return checked;
}

cl::Event PointPlanState::enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before,
                                  const InputArray& points, const OutputTargets& targets, const OutputArray& status) {
    std::optional<OutputArray> of_status;
    if (status.is_given() && points.count > 0) of_status = checked_status(context(), status, points.count);
    std::optional<targets::DeviceTargets> whole;
    if (points.count > 0) whole = check(points, targets, of_status.value_or(OutputArray()));
    context().require_usable();
    if (queue() == context().queue()() && !before.empty()) context().add_waiting_run();
    engine::CommandChain& chain = runs_.begin(queue, std::move(before));
    if (points.count == 0) {
        chain.then([](const auto& to, auto* wait, auto* event) { to.enqueueMarkerWithWaitList(wait, event); });
    } else {
        const engine::Launches launches(chain, run->kernels());
        const points::DevicePoints all = points::points_in(points);
        const PointLimits usable = points::limits_of(points::usable_range(inputs.mesh->box).limits);
        run->enqueue_measure(launches, tools(), all, usable, *inputs.mesh);
        for (std::size_t begin = 0; begin < all.count; begin += run->most()) {
            const std::size_t part = std::min(run->most(), all.count - begin);
            const bool is_all = part == all.count;
            const targets::DeviceTargets of_part =
                is_all
                    ? *whole
                    : targets::DeviceTargets(targets::targets_from(targets, begin), targets::row_of(part), context());
            const engine::OutputBuffers buffers = packed.buffers_for(of_part);
            std::optional<points::PointBatch::Status> status_of_part;
            if (of_status)
                status_of_part = {cl::Buffer(of_status->device, true),
                                  {static_cast<clsdf_int64>(of_status->offset) +
                                       static_cast<clsdf_int64>(begin) * of_status->strides[0],
                                   of_status->strides[0], 1}};
            run->enqueue(launches, tools(), inputs,
                         {all.part(begin, part), usable, half_width, buffers, true, std::move(status_of_part)}, {});
            packed.enqueue_copies(launches, tools(), of_part, part);
        }
    }
    queue.flush();
    return chain.last();
}

}  // namespace calls

void DistanceTransform::State::plan_points(PointPlan::State& made, const CallOptions& call) {
    device::Context& context = this->context();
    if (&device::context_of(made.device) != &context)
        throw Error(ErrorCode::invalid_argument,
                    "the transform has another device than the plan; update the plan with a transform of its Device");
    if (kept_mesh->restriction() != nullptr)
        throw Error(ErrorCode::unsupported,
                    "the transform is restricted, and points of a plan, which the host does not see, may lie beyond "
                    "its regions; plan points of the whole transform");
    mutex.check_thread();
    made.wait();  // before the mutex is locked: other threads may use the transform
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    calls::RunningCall running{call};
    running.throw_if_stopped();
    context.begin_call();
    const bool by_group = programs.body == KernelBody::by_group;
    test(checks::point_subject(device, programs,
                               by_group ? checks::PointKernels::of_all : checks::PointKernels::of_plans),
         running);
    const Stopwatch watch;
    // A search by another body takes other memory.
    const bool needs_memory = !made.run || made.programs.body != programs.body;
    points::PointInputs inputs;
    std::optional<points::PointRun> run;
    points::PackedOutputs packed;
    const auto make = [&] {
        run.reset();
        context.run_or_drain([&] {
            inputs = planned_point_inputs(made.outputs);
            if (!needs_memory) return;
            run.emplace(tools(), std::min(made.count, points::most_points));
            packed.make_room(*pool, made.outputs, run->most());
        });
    };
    calls::with_remedies(&running, {forgetting()}, make);
    if (inputs.needs_deep_stack())
        test(checks::point_subject(device, programs, checks::PointKernels::of_deep_trees), running);
    // Runs on other queues read what was enqueued here.
    device::guarded([&] { context.queue().finish(); });
    made.programs = programs;
    made.inputs = std::move(inputs);
    if (needs_memory) {
        made.run.emplace(std::move(*run));
        made.packed = std::move(packed);
    }
    CallStatistics& statistics = running.statistics;
    statistics.triangles = kept_mesh->face_count();
    statistics.polyhedra_seconds = watch.seconds();
    statistics.device_bytes = made.own_bytes();
    made.published = statistics.published();
}

points::PointInputs DistanceTransform::State::planned_point_inputs(OutputSet outputs) {
    points::PointInputs inputs;
    inputs.mesh = kept_points->mesh();
    inputs.sign_faces = kept_points->sign_faces(sign);
    if (!inputs.has_exact_signs())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} has a coordinate that is not 0 and, in units of {}, smaller than 2^-300 or greater "
                                "than 2^300: a plan of points cannot decide signs then; set such coordinates to 0, or "
                                "ask with query()",
                                kept_mesh->name(), inputs.mesh->lattice.unit));
    inputs.triangles = kept_points->triangles();
    if (programs.body == KernelBody::by_group)
        inputs.tree = kept_points->fitted_tree();
    else
        inputs.leaves = kept_points->wide_leaves();
    if (sign != SignRule::none) inputs.sides = kept_points->face_sides(sign, true);
    const NormalsNeeded normals = normals_for(outputs);
    inputs.sites = kept_mesh->sites(engine::names_sites(outputs), normals.are_needed || inputs.sides != nullptr);
    inputs.sign = sign;
    inputs.is_inside_out = normals.is_inside_out;
    return inputs;
}

PointPlan::PointPlan(std::unique_ptr<State> state) : state_(std::move(state)) {}
PointPlan::PointPlan(PointPlan&&) noexcept = default;
PointPlan& PointPlan::operator=(PointPlan&&) noexcept = default;
PointPlan::~PointPlan() = default;

PointPlan::State& PointPlan::state() const {
    return held_by(state_, "PointPlan");
}

std::size_t PointPlan::count() const {
    return state().count;
}

double PointPlan::half_width() const {
    return state().half_width;
}

OutputSet PointPlan::outputs() const {
    return state().outputs;
}

SignRule PointPlan::sign() const {
    return state().inputs.sign;
}

const TransformStatistics& PointPlan::statistics() const {
    return state().published;
}

void PointPlan::enqueue(cl_command_queue queue, const InputArray& points, const OutputTargets& targets,
                        std::span<const cl_event> wait_list, cl_event* done, const OutputArray& status) {
    State& state = this->state();
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] {
            const device::Context& context = state.context();
            const cl::Event last = state.enqueue(targets::queue_of(context, queue),
                                                 targets::events_of(context, wait_list), points, targets, status);
            if (done == nullptr) return;
            clRetainEvent(last());
            *done = last();
        });
    });
}

void PointPlan::update(const DistanceTransform& transform, const CallOptions& call) {
    with_host_memory("for the plan", [&] { transform.state().plan_points(state(), call); });
}

PointPlan DistanceTransform::plan_points(std::size_t count, double half_width, OutputSet outputs,
                                         const CallOptions& call) const {
    return with_host_memory("for the plan; give fewer points", [&] {
        State& state = this->state();
        calls::check_half_width(half_width);
        if (count == 0 || count >= std::numeric_limits<cl_uint>::max())
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("a plan is asked for that takes {} points at a time; it takes 1 to 2^32 - 2", count));
        auto made = std::make_unique<PointPlan::State>(state.device, state.programs, state.pool);
        made->count = count;
        made->half_width = std::abs(half_width);
        made->outputs = targets::extras_of(outputs) | Output::distance;
        state.plan_points(*made, call);
        return PointPlan(std::move(made));
    });
}

}  // namespace clsdf

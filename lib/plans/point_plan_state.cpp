#include "plans/point_plan_state.hpp"

#include "core/outputs.hpp"
#include "mesh/input_arrays.hpp"
#include "mesh/triples.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/target_layout.hpp"
#include "targets/target_overlap.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::plans {

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

void PointPlanState::replace(PlannedPoints made, const engine::Programs& programs) {
    made_.inputs = std::move(made.inputs);
    programs_ = programs;
    if (!made.run) return;
    made_.run.emplace(std::move(*made.run));
    made_.packed = std::move(made.packed);
}

targets::DeviceTargets PointPlanState::check(const InputArray& points, const OutputTargets& targets,
                                             const OutputArray& status) const {
    check_array(points, ArrayKind::positions, "points", ErrorCode::invalid_argument);
    const std::size_t count = asked().count;
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
    const OutputSet given = targets.outputs();
    for (const OutputInfo& row : output_table())
        require_target(row, asked().outputs.contains(row.output), given.contains(row.output));
    targets::DeviceTargets checked(targets::targets_from(targets, 0), targets::row_of(points.count), context());
    std::vector<targets::WrittenArray> written;
    checked.add_written(0, written);
    targets::refuse_overlap(written);
    points::check_device_points(context(), points);
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

void PointPlanState::enqueue(const RunOptions& options, const InputArray& points, const OutputTargets& targets,
                             const OutputArray& status) {
    if (points.count == 0) {
        run(options, [](engine::CommandChain&) {});
        return;
    }
    std::optional<OutputArray> of_status;
    if (status.is_given()) of_status = checked_status(context(), status, points.count);
    const targets::DeviceTargets checked = check(points, targets, of_status.value_or(OutputArray()));
    run(options, [&](engine::CommandChain& chain) { enqueue_batches(chain, points, targets, checked, of_status); });
}

void PointPlanState::enqueue_batches(engine::CommandChain& chain, const InputArray& points,
                                     const OutputTargets& targets, const targets::DeviceTargets& checked,
                                     const std::optional<OutputArray>& status) {
    auto& [inputs, run, packed] = made_;
    const engine::Launches launches(chain, context().kernels());
    const points::DevicePoints all = points::points_in(points);
    const PointLimits usable = points::limits_of(points::usable_range(inputs.mesh->box).limits);
    run->enqueue_measure(launches, tools(), all, usable, *inputs.mesh);
    for (std::size_t begin = 0; begin < all.count; begin += run->most()) {
        const std::size_t part = std::min(run->most(), all.count - begin);
        const bool is_all = part == all.count;
        const targets::DeviceTargets of_part =
            is_all ? checked
                   : targets::DeviceTargets(targets::targets_from(targets, begin), targets::row_of(part), context());
        const engine::OutputBuffers buffers = packed.buffers_for(of_part);
        std::optional<points::PointBatch::Status> status_of_part;
        if (status)
            status_of_part = {
                cl::Buffer(status->device, true),
                {static_cast<clsdf_int64>(status->offset) + static_cast<clsdf_int64>(begin) * status->strides[0],
                 status->strides[0], 1}};
        run->enqueue(launches, tools(), inputs,
                     {all.part(begin, part), usable, asked().half_width, buffers, true, std::move(status_of_part)}, {});
        packed.enqueue_copies(launches, tools(), of_part, part);
    }
}

}  // namespace clsdf::plans

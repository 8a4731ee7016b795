#include "plans/point_plan_state.hpp"

#include "core/outputs.hpp"
#include "mesh/input_arrays.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/target_overlap.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf::plans {

namespace {

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, what};
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

void PointPlanState::replace(PlannedPoints made, engine::Programs programs) noexcept {
    static_assert(std::is_nothrow_move_constructible_v<points::PointRun>);
    static_assert(std::is_nothrow_move_assignable_v<points::PointInputs>);
    static_assert(std::is_nothrow_move_assignable_v<points::PackedOutputs>);
    static_assert(std::is_nothrow_move_assignable_v<engine::Programs>);
    made_.inputs = std::move(made.inputs);
    programs_ = std::move(programs);
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
    points::check_device_points(context(), points);
    // Points are read while results are written.
    written.push_back(points::array_of(points));
    if (status.is_given()) {
        const targets::BufferPlace begin = targets::place_of(status.device, status.offset);
        written.push_back({.memory = begin.memory(),
                           .first = begin.byte,
                           .width = 1,
                           .size = targets::row_of(points.count).size,
                           .strides = status.strides,
                           .name = "the status of points"});
    }
    if (const auto overlap = targets::find_overlap(written)) targets::throw_overlap(*overlap);
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

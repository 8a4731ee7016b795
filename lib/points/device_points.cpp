#include "points/device_points.hpp"

#include "core/refuse.hpp"
#include "device/read_back.hpp"
#include "mesh/input_arrays.hpp"
#include "targets/mapped_memory.hpp"

#include <clsdf/error.hpp>

#include <algorithm>

namespace clsdf::points {

void check_device_points(const device::Context& context, const InputArray& points) {
    if (points.device == nullptr)
        refuse_unsupported(
            "the points are memory of the host, and a plan reads the device's; give it a buffer of the device, "
            "or ask with query()");
    const cl::Buffer memory(points.device, true);
    targets::require_buffer(context, memory, "the memory of the points");
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_WRITE_ONLY) != 0)
        refuse(
            "the points are a buffer made with CL_MEM_WRITE_ONLY; kernels read it, so make it with "
            "CL_MEM_READ_WRITE or CL_MEM_READ_ONLY");
    range_of(points, memory.getInfo<CL_MEM_SIZE>(), "points", ErrorCode::invalid_argument);
}

DevicePoints DevicePoints::part(std::size_t begin, std::size_t part_count) const {
    DevicePoints result = *this;
    result.source.first += static_cast<clsdf_int64>(begin) * source.stride;
    result.count = part_count;
    return result;
}

targets::WrittenArray array_of(const InputArray& points) {
    const Steps steps = steps_of(points);
    const targets::BufferPlace begin = targets::place_of(points.device, points.offset);
    return {.memory = begin.memory(),
            .first = begin.byte,
            .width = bytes_of(points.type),
            .size = {static_cast<std::int64_t>(points.count), 1, 1},
            .strides = {steps.triple, 0, 0},
            .components = 3,
            .component_stride = steps.number,
            .name = "the points"};
}

DevicePoints points_in(const InputArray& array) {
    const Steps steps = steps_of(array);
    return {cl::Buffer(array.device, true),
            {static_cast<clsdf_int64>(array.offset), steps.triple, steps.number, array.type == ElementType::float64},
            array.count};
}

DevicePoints packed_points(const cl::Buffer& positions, std::size_t count) {
    return {positions, {0, sizeof(Vec3), sizeof(double), 1}, count};
}

PointLimits limits_of(const Box& box) {
    PointLimits limits{};
    std::copy(box.lower.begin(), box.lower.end(), limits.lower);
    std::copy(box.upper.begin(), box.upper.end(), limits.upper);
    return limits;
}

std::array<UnusablePoints, 2> unusable_points(const engine::DeviceTools& tools, const DevicePoints& points,
                                              const PointCells& found) {
    return device::guarded([&] {
        std::array<UnusablePoints, 2> result;
        for (const int why : {CLSDF_POINT_NOT_FINITE, CLSDF_POINT_TOO_FAR}) {
            UnusablePoints& unusable = result[why == CLSDF_POINT_TOO_FAR];
            unusable = {why == CLSDF_POINT_TOO_FAR, found.unusable[why], found.first[why], {}};
            if (unusable.count == 0) continue;
            const auto first = points.source.first + static_cast<clsdf_int64>(unusable.first) * points.source.stride;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto at =
                    static_cast<std::size_t>(first + static_cast<clsdf_int64>(axis) * points.source.component);
                unusable.position[axis] =
                    points.source.is_double != 0
                        ? device::read_value<double>(tools.context, points.memory, at)
                        : static_cast<double>(device::read_value<float>(tools.context, points.memory, at));
            }
        }
        return result;
    });
}

}  // namespace clsdf::points

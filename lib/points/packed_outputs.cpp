#include "points/packed_outputs.hpp"

#include "launch/programs.hpp"
#include "point_order.h"
#include "targets/target_layout.hpp"

namespace clsdf::points {

namespace {

constexpr const char* purpose = "outputs of points before they are copied";

}  // namespace

void PackedOutputs::make_room(device::BufferPool& pool, OutputSet outputs, std::size_t count) {
    for_each_output(
        [&](const OutputInfo& row, device::BufferPool::Lease& values) {
            const std::size_t bytes = count * sample_bytes(row, true);
            if (outputs.contains(row.output) && values.bytes() < bytes) values = pool.lease(bytes, purpose);
        },
        values_);
}

void PackedOutputs::make_room(device::BufferPool& pool, const targets::DeviceTargets& targets, std::size_t count) {
    OutputSet copied;
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, const cl::Buffer& buffer) {
            if (array.is_wanted && buffer() == nullptr) copied.insert(row.output);
        },
        targets.arrays, targets.buffers);
    make_room(pool, copied, count);
}

engine::OutputBuffers PackedOutputs::buffers_for(const targets::DeviceTargets& targets) const {
    engine::OutputBuffers buffers = targets.buffers;
    for_each_output(
        [](const OutputInfo&, const targets::HostArray& array, const device::BufferPool::Lease& values,
           cl::Buffer& buffer) {
            if (array.is_wanted && buffer() == nullptr) buffer = *values;
        },
        targets.arrays, values_, buffers);
    return buffers;
}

void PackedOutputs::enqueue_copies(const engine::Launches& launches, const engine::DeviceTools& tools,
                                   const targets::DeviceTargets& targets, std::size_t count) const {
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, const OutputArray& target, const cl::Buffer& direct,
            const device::BufferPool::Lease& values) {
            if (!array.is_wanted || direct() != nullptr) return;
            const ValuePlaces places{static_cast<clsdf_int64>(target.offset), target.strides[0],
                                     target.component_stride};
            launches.launch(tools.programs.point_order, "store_values", {count}, static_cast<cl_uint>(count),
                            static_cast<cl_uint>(row.components), static_cast<cl_uint>(bytes_of(target.type)), places,
                            *values, cl::Buffer(target.device, true));
        },
        targets.arrays, targets.targets, targets.buffers, values_);
}

std::size_t PackedOutputs::device_bytes() const {
    std::size_t bytes = 0;
    for_each_output([&](const OutputInfo&, const device::BufferPool::Lease& values) { bytes += values.bytes(); },
                    values_);
    return bytes;
}

}  // namespace clsdf::points

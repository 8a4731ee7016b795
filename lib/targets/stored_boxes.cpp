#include "targets/stored_boxes.hpp"

#include "device/buffer_pool.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

namespace clsdf::targets {

namespace {

// On a GPU so many work-items store a row together.
constexpr std::size_t pieces_of_gpu = 32;

}  // namespace

std::optional<StoredBox> stored_box(const Grid& block, const Grid& request, const OutputArray& target) {
    StoredBox box{};
    Index3 in_block{};
    box.to = static_cast<std::int64_t>(target.offset);
    box.component_stride = target.component_stride;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t begin = std::max(block.first[axis], request.first[axis]);
        const std::int64_t end =
            std::min(block.first[axis] + block.size[axis], request.first[axis] + request.size[axis]);
        if (begin >= end) return std::nullopt;
        in_block[axis] = begin - block.first[axis];
        box.size[axis] = static_cast<std::int32_t>(end - begin);
        box.strides[axis] = target.strides[axis];
        box.to += (begin - request.first[axis]) * target.strides[axis];
    }
    box.from = static_cast<std::int64_t>(block.offset(in_block[0], in_block[1], in_block[2]));
    return box;
}

BoxStore::BoxStore(const device::Context& context, const cl::Program& program, const Grid& block,
                   const StoredElements& elements, const cl::Buffer& samples, std::vector<TargetBox> places)
    : kernel_(context.kernels(), program, "store_boxes"), planned_(std::move(places)) {
    for (const TargetBox& place : planned_) written_.push_back(place.box);
    boxes_ = device::copied(context, written_);
    const device::Context::Capabilities& device = context.capabilities();
    pieces_ = device.is_processor ? 1 : pieces_of_gpu;
    group_rows_ = std::clamp<std::size_t>(device.largest_group / pieces_, 1, 8);
    to_ = engine::set_arguments(kernel_, 0, boxes_, static_cast<cl_int>(block.size[0]),
                                static_cast<cl_long>(block.size[0] * block.size[1]),
                                static_cast<cl_int>(elements.components), static_cast<cl_int>(elements.bytes), samples);
    for (const StoredBox& box : written_)
        rows_ = std::max(rows_, static_cast<std::size_t>(box.size[1]) * static_cast<std::size_t>(box.size[2]));
    rows_ = engine::in_whole_groups(rows_, group_rows_);
}

void BoxStore::write(engine::CommandChain& chain, std::span<const TargetBox> places) {
    // If the last write failed, the device may have old boxes. Then all are written again.
    const bool is_known =
        last_write_() == nullptr || last_write_.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() >= CL_COMPLETE;
    for (std::size_t n = 0; n < places.size(); ++n) {
        if (is_known && std::memcmp(&places[n].box, &written_[n], sizeof(StoredBox)) == 0) continue;
        chain.then([&](auto& queue, auto* wait, auto* event) {
            // A fill copies its pattern at once.
            queue.enqueueFillBuffer(boxes_, places[n].box, n * sizeof(StoredBox), sizeof(StoredBox), wait, event);
        });
        last_write_ = chain.last();
        written_[n] = places[n].box;
    }
}

void BoxStore::enqueue(engine::CommandChain& chain, std::span<const TargetBox> places) {
    if (places.empty()) places = planned_;
    write(chain, places);
    for (std::size_t box = 0, count = 0; box < places.size(); box += count) {
        const cl_mem memory = places[box].memory;
        const std::span<const TargetBox> rest = places.subspan(box);
        const auto end = std::ranges::find_if(rest, [&](const TargetBox& place) { return place.memory != memory; });
        count = static_cast<std::size_t>(end - rest.begin());
        kernel_.setArg(to_, cl::Buffer(memory, true));
        engine::divided({pieces_, rows_, count}, {engine::most_groups * group_rows_, engine::most_groups},
                        [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                            chain.then_launch(kernel_, cl::NDRange(0, y, box + z), items,
                                              cl::NDRange(pieces_, group_rows_, 1));
                        });
    }
}

}  // namespace clsdf::targets

#include "calls/stored_boxes.hpp"

#include "device/buffer_pool.hpp"
#include "device/read_back.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace clsdf::calls {

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
                   const StoredElements& elements, const cl::Buffer& samples, std::vector<Place> places)
    : kernel_(context.kernels(), program, "store_boxes"), planned_(std::move(places)) {
    for (const Place& place : planned_) written_.push_back(place.box);
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

void BoxStore::write(engine::CommandChain& chain, std::span<const Place> places) {
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

void BoxStore::enqueue(engine::CommandChain& chain, std::span<const Place> places) {
    if (places.empty()) places = planned_;
    write(chain, places);
    for (std::size_t box = 0, count = 0; box < places.size(); box += count) {
        const cl_mem memory = places[box].memory;
        const std::span<const Place> rest = places.subspan(box);
        const auto end = std::ranges::find_if(rest, [&](const Place& place) { return place.memory != memory; });
        count = static_cast<std::size_t>(end - rest.begin());
        kernel_.setArg(to_, cl::Buffer(memory, true));
        engine::divided({pieces_, rows_, count}, {engine::most_groups * group_rows_, engine::most_groups},
                        [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                            chain.then_launch(kernel_, cl::NDRange(0, y, box + z), items,
                                              cl::NDRange(pieces_, group_rows_, 1));
                        });
    }
}

namespace {

/// Boxes of samples, in blocks of rows, to targets with strides; the third to another place than it was planned for.
template <typename Value>
bool stores_right(const device::Context& context, const cl::Program& program) {
    Grid block, request;
    block.size = {11, 6, 5};
    request.first = {2, 1, -1};
    request.size = {40, 4, 4};
    constexpr std::size_t components = 3;
    constexpr auto stride = static_cast<std::ptrdiff_t>(sizeof(Value));
    OutputArray target;
    target.offset = 7 * sizeof(Value);
    target.strides = {2 * stride, 90 * stride, 400 * stride};
    target.component_stride = 1800 * stride;
    const StoredBox box = *stored_box(block, request, target);
    const auto place_at = [&](std::ptrdiff_t elements_on) {
        StoredBox moved = box;
        moved.to += elements_on * stride;
        return moved;
    };
    const std::array stored{box, place_at(6000), place_at(6001)};
    std::vector<Value> from(block.sample_count() * components);
    std::vector<Value> to(12000, Value{});
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = static_cast<Value>(1 + i * 7 % 251);
    std::vector<Value> expected = to;
    for (const StoredBox& of : stored)
        for (int z = 0; z < of.size[2]; ++z)
            for (int y = 0; y < of.size[1]; ++y)
                for (int x = 0; x < of.size[0]; ++x)
                    for (std::size_t c = 0; c < components; ++c) {
                        const std::size_t sample = static_cast<std::size_t>(of.from) + block.offset(x, y, z);
                        const std::int64_t place = of.to + x * of.strides[0] + y * of.strides[1] + z * of.strides[2] +
                                                   static_cast<std::int64_t>(c) * of.component_stride;
                        expected[static_cast<std::size_t>(place / stride)] = from[sample * components + c];
                    }
    const cl::Buffer samples = device::copied(context, from);
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, to.size() * sizeof(Value),
                            to.data());
    const StoredElements elements{components, sizeof(Value)};
    engine::CommandChain chain(context.queue(), {});
    BoxStore both(context, program, block, elements, samples, {{memory(), stored[0]}, {memory(), stored[1]}});
    both.enqueue(chain);
    BoxStore moved(context, program, block, elements, samples, {{memory(), stored[0]}});
    moved.enqueue(chain, std::array{Place{memory(), stored[2]}});
    device::read_values(context, memory, to);
    return to == expected;
}

}  // namespace

checks::TestSubject stored_boxes_subject(const Device& device, const engine::Programs& programs) {
    checks::TestSubject subject;
    subject.name = "stored boxes";
    subject.build = [&programs](const device::BuildWatch& watch) { return std::vector{programs.store.get(watch)}; };
    subject.difference = [&device, &programs](const device::BuildWatch&) -> std::optional<std::string> {
        const device::Context& context = device::context_of(device);
        if (stores_right<std::uint8_t>(context, programs.store) &&
            stores_right<std::uint32_t>(context, programs.store) &&
            stores_right<std::uint64_t>(context, programs.store))
            return std::nullopt;
        return "elements are stored in wrong places";
    };
    return subject;
}

}  // namespace clsdf::calls

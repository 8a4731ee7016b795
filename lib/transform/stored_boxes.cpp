#include "transform/stored_boxes.hpp"

#include "device/buffer_pool.hpp"
#include "transform/self_test.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <type_traits>

namespace clsdf::transform {

namespace {

enum StoreArgument : cl_uint {
    store_boxes,
    store_row,
    store_slice,
    store_components,
    store_element_bytes,
    store_widened,
    store_from,
    store_to
};

// On a GPU so many work-items store a row together.
constexpr std::size_t pieces_of_gpu = 32;

}  // namespace

std::optional<StoredBox> stored_box(const Grid& block, const Grid& request, const OutputTarget& target) {
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
                   const StoredElements& elements, const cl::Buffer& samples, cl_mem memory,
                   const std::vector<StoredBox>& boxes)
    : kernel_(program, "store_boxes"), boxes_(device::copied(context, boxes)), box_count_(boxes.size()) {
    const device::Context::Capabilities& device = context.capabilities();
    pieces_ = device.is_processor ? 1 : pieces_of_gpu;
    group_rows_ = std::clamp<std::size_t>(device.largest_group / pieces_, 1, 8);
    kernel_.setArg(store_boxes, boxes_);
    kernel_.setArg(store_row, static_cast<cl_int>(block.size[0]));
    kernel_.setArg(store_slice, static_cast<cl_long>(block.size[0] * block.size[1]));
    kernel_.setArg(store_components, static_cast<cl_int>(elements.components));
    kernel_.setArg(store_element_bytes, static_cast<cl_int>(elements.bytes));
    kernel_.setArg(store_widened, static_cast<cl_int>(elements.are_widened));
    kernel_.setArg(store_from, samples);
    if (memory != nullptr) kernel_.setArg(store_to, cl::Buffer(memory, true));
    for (const StoredBox& box : boxes)
        rows_ = std::max(rows_, static_cast<std::size_t>(box.size[1]) * static_cast<std::size_t>(box.size[2]));
    rows_ = in_whole_groups(rows_, group_rows_);
}

void BoxStore::move(cl_mem memory, const StoredBox& box) {
    kernel_.setArg(store_to, cl::Buffer(memory, true));
    moved_ = box;
}

void BoxStore::enqueue(CommandChain& chain) {
    if (moved_)
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueFillBuffer(boxes_, *moved_, 0, sizeof(StoredBox), wait, event);  // which copies the box
        });
    moved_.reset();
    divided({pieces_, rows_, box_count_}, {most_groups * group_rows_, most_groups},
            [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                chain.then([&](auto& queue, auto* wait, auto* event) {
                    queue.enqueueNDRangeKernel(kernel_, cl::NDRange(0, y, z), items,
                                               cl::NDRange(pieces_, group_rows_, 1), wait, event);
                });
            });
}

namespace {

/// Boxes of samples of type From, in blocks of rows, to targets of type To with strides; the second box after a move.
template <typename From, typename To>
bool stores_right(const device::Context& context, const cl::Program& program) {
    const cl::CommandQueue& queue = context.queue();
    Grid block, request;
    block.size = {11, 6, 5};
    request.first = {2, 1, -1};
    request.size = {40, 4, 4};
    constexpr std::size_t components = 3;
    constexpr auto stride = static_cast<std::ptrdiff_t>(sizeof(To));
    OutputTarget target;
    target.offset = 7 * sizeof(To);
    target.strides = {2 * stride, 90 * stride, 400 * stride};
    target.component_stride = 1800 * stride;
    StoredBox box = *stored_box(block, request, target);
    std::vector<StoredBox> boxes(1, box);
    box.to += 6000 * stride;
    boxes.push_back(box);
    box.to += stride;
    std::vector<From> from(block.sample_count() * components);
    std::vector<To> to(12000, To{});
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = static_cast<From>(1 + i * 7 % 251);
    std::vector<To> expected = to;
    const auto expect = [&](const StoredBox& stored) {
        for (int z = 0; z < stored.size[2]; ++z)
            for (int y = 0; y < stored.size[1]; ++y)
                for (int x = 0; x < stored.size[0]; ++x)
                    for (std::size_t c = 0; c < components; ++c) {
                        const std::size_t sample = static_cast<std::size_t>(stored.from) + block.offset(x, y, z);
                        const std::int64_t place = stored.to + x * stored.strides[0] + y * stored.strides[1] +
                                                   z * stored.strides[2] +
                                                   static_cast<std::int64_t>(c) * stored.component_stride;
                        expected[static_cast<std::size_t>(place / stride)] =
                            static_cast<To>(from[sample * components + c]);
                    }
    };
    for (const StoredBox& stored : boxes) expect(stored);
    expect(box);
    const cl::Buffer samples = device::copied(context, from);
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, to.size() * sizeof(To),
                            to.data());
    const StoredElements elements{components, sizeof(From), !std::is_same_v<From, To>};
    CommandChain chain(queue, {});
    BoxStore both(context, program, block, elements, samples, memory(), boxes);
    both.enqueue(chain);
    BoxStore moved(context, program, block, elements, samples, memory(), {boxes.front()});
    moved.move(memory(), box);
    moved.enqueue(chain);
    queue.enqueueReadBuffer(memory, CL_TRUE, 0, to.size() * sizeof(To), to.data());
    return to == expected;
}

std::optional<std::string> run_store_test(const device::Context& context, const cl::Program& program) {
    if (!stores_right<std::uint8_t, std::uint8_t>(context, program) ||
        !stores_right<std::uint32_t, std::uint32_t>(context, program) ||
        !stores_right<std::uint64_t, std::uint64_t>(context, program))
        return "elements are stored in wrong places";
    if (!stores_right<float, double>(context, program)) return "floats are stored as wrong doubles";
    return std::nullopt;
}

}  // namespace

bool ensure_store_tested(const Device& device, const Programs& programs, const device::BuildWatch& watch) {
    return device::guarded([&] {
        const cl::Program program = programs.store(device::context_of(device), watch);
        return test_once(device, {"stored boxes", {program}}, watch,
                         [&] { return run_store_test(device::context_of(device), program); });
    });
}

}  // namespace clsdf::transform

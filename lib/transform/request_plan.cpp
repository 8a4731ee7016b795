#include "transform/request_plan.hpp"

#include "core/keep.hpp"
#include "core/moved_from.hpp"
#include "core/stopwatch.hpp"
#include "device/has_ended.hpp"
#include "device/host_filling.hpp"
#include "scan/commands.hpp"
#include "scan/layout_of.hpp"
#include "scan/programs.hpp"
#include "scan/slabs.hpp"
#include "stored_box.h"
#include "transform/self_test.hpp"
#include "transform/transform_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

namespace clsdf {

namespace transform {

namespace {

enum StoreArgument : cl_uint {
    store_boxes,
    store_row,
    store_slice,
    store_components,
    store_element_bytes,
    store_from,
    store_to
};

// Rows of a work-group. On a GPU 32 work-items store a row together.
constexpr std::size_t group_rows = 8, pieces_of_gpu = 32;

struct StoreRange {
    cl::NDRange all, group;
};

StoreRange store_range(const device::Context& context, std::size_t rows, std::size_t boxes) {
    const std::size_t pieces = context.capabilities().is_processor ? 1 : pieces_of_gpu;
    return {cl::NDRange(pieces, in_whole_groups(rows, group_rows), boxes), cl::NDRange(pieces, group_rows, 1)};
}

template <typename>
using BytesOf = std::size_t;
/// The boxes that go to each of the caller's buffers.
template <typename>
using BoxesOf = std::map<cl_mem, std::vector<StoredBox>>;

/// The samples that a block and a request have in common; nothing if there are none.
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

cl::Kernel store_kernel(const cl::Program& program, const cl::Buffer& boxes, const Grid& block, std::size_t components,
                        std::size_t element_bytes, const cl::Buffer& from, const cl::Buffer& to) {
    cl::Kernel kernel(program, "store_boxes");
    kernel.setArg(store_boxes, boxes);
    kernel.setArg(store_row, static_cast<cl_int>(block.size[0]));
    kernel.setArg(store_slice, static_cast<cl_long>(block.size[0] * block.size[1]));
    kernel.setArg(store_components, static_cast<cl_int>(components));
    kernel.setArg(store_element_bytes, static_cast<cl_int>(element_bytes));
    kernel.setArg(store_from, from);
    kernel.setArg(store_to, to);
    return kernel;
}

/// Boxes of numbers, of elements of each width, to targets with strides.
std::optional<std::string> run_store_test(const Device& device, const cl::Program& program) {
    const device::Context& context = device::context_of(device);
    const cl::CommandQueue& queue = context.queue();
    Grid block, request;
    block.size = {11, 6, 5};
    request.first = {2, 1, -1};
    request.size = {40, 4, 4};
    constexpr std::size_t components = 3, copies = 2;
    for (const std::size_t width : {std::size_t{1}, std::size_t{4}, std::size_t{8}}) {
        const auto stride = static_cast<std::ptrdiff_t>(width);
        OutputTarget target;
        target.offset = 7 * width;
        target.strides = {2 * stride, 90 * stride, 400 * stride};
        target.component_stride = 1800 * stride;
        StoredBox box = *stored_box(block, request, target);
        std::vector<StoredBox> boxes(1, box);
        box.to += 6000 * stride;
        boxes.push_back(box);
        std::vector<unsigned char> from(block.sample_count() * components * width), to(12000 * width, 0);
        for (std::size_t i = 0; i < from.size(); ++i) from[i] = static_cast<unsigned char>(1 + i * 7 % 251);
        std::vector<unsigned char> expected = to;
        for (std::size_t copy = 0; copy < copies; ++copy)
            for (int z = 0; z < box.size[2]; ++z)
                for (int y = 0; y < box.size[1]; ++y)
                    for (int x = 0; x < box.size[0]; ++x)
                        for (std::size_t c = 0; c < components; ++c) {
                            const std::size_t sample =
                                static_cast<std::size_t>(boxes[copy].from) + block.offset(x, y, z);
                            const std::int64_t place = boxes[copy].to + x * box.strides[0] + y * box.strides[1] +
                                                       z * box.strides[2] +
                                                       static_cast<std::int64_t>(c) * box.component_stride;
                            std::copy_n(from.begin() + static_cast<std::ptrdiff_t>((sample * components + c) * width),
                                        width, expected.begin() + place);
                        }
        const cl::Buffer samples = device::copied(context, from), of_boxes = device::copied(context, boxes);
        const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, to.size(), to.data());
        const cl::Kernel kernel = store_kernel(program, of_boxes, block, components, width, samples, memory);
        const StoreRange range = store_range(context, 16, copies);
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, range.all, range.group);
        queue.enqueueReadBuffer(memory, CL_TRUE, 0, to.size(), to.data());
        if (to != expected) return fmt::format("elements of {} bytes are stored in wrong places", width);
    }
    return std::nullopt;
}

}  // namespace

bool ensure_store_tested(const Device& device, const Programs& programs, const device::BuildWatch& watch) {
    return device::guarded([&] {
        const cl::Program program = programs.store(device::context_of(device), watch);
        return test_once(device, {"stored boxes", {program}}, watch, [&] { return run_store_test(device, program); });
    });
}

RequestPlanState::RequestPlanState(Device device_in, std::vector<Request> requests_in)
    : device(std::move(device_in)),
      pool(std::make_shared<device::BufferPool>(device::shared_context_of(device))),
      requests(std::move(requests_in)) {}

RequestPlanState::~RequestPlanState() {
    if (device::has_ended(last_)) return;
    const cl_int code = clWaitForEvents(1, &last_());
    if (code == CL_SUCCESS || code == CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) return;
    // The plans of the parts cannot tell either, and keep what is theirs.
    keep_for_good(samples_);
    keep_for_good(boxes_);
}

void RequestPlanState::make_room(std::span<const Block> blocks, std::span<const DeviceTargets> targets) {
    PerOutput<BytesOf> most{};
    for (const Block& block : blocks) {
        if (block.in_place) continue;
        for_each_output(
            [&](const OutputRow& row, const HostArray& array, std::size_t& bytes) {
                if (!array.is_wanted) return;
                bytes = std::max(bytes, block.grid.sample_count() * row.sample_bytes(array.in_double));
            },
            targets[block.batch->requests.front()].arrays(), most);
    }
    for_each_output(
        [&](const OutputRow&, std::size_t bytes, device::BufferPool::Lease& lease) {
            if (bytes > 0) lease = pool->lease(bytes, "samples of a plan's blocks");
        },
        most, samples_);
}

void RequestPlanState::add(const Block& block, std::unique_ptr<PlanState> plan, std::span<const DeviceTargets> targets,
                           const Programs& programs) {
    const std::vector<std::size_t>& chosen = block.batch->requests;
    if (block.in_place) {
        parts_.push_back({std::move(plan), *targets[chosen.front()].in_place(), {}});
        return;
    }
    const device::Context& context = device::context_of(device);
    const cl::Program program = programs.store(device::context_of(device));
    Part part{std::move(plan), {}, {}};
    PerOutput<BoxesOf> all_boxes;
    for (const std::size_t n : chosen)
        for_each_output(
            [&](const OutputRow&, const OutputTarget& target, auto& boxes) {
                if (!target.is_given()) return;
                if (const auto box = stored_box(block.grid, requests[n].grid, target))
                    boxes[target.device].push_back(*box);
            },
            targets[n].targets(), all_boxes);
    for_each_output(
        [&](const OutputRow& row, const HostArray& array, const device::BufferPool::Lease& lease, const auto& boxes,
            cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            buffer = *lease;
            if (array.in_double) part.buffers.in_double |= row.bit;
            const std::size_t element_bytes = row.sample_bytes(array.in_double) / row.components;
            for (const auto& [memory, of_memory] : boxes) {
                std::size_t rows = 0;
                for (const StoredBox& box : of_memory)
                    rows =
                        std::max(rows, static_cast<std::size_t>(box.size[1]) * static_cast<std::size_t>(box.size[2]));
                boxes_.push_back(device::copied(context, of_memory));
                box_bytes_ += of_memory.size() * sizeof(StoredBox);
                const StoreRange range = store_range(context, rows, of_memory.size());
                part.stores.push_back({store_kernel(program, boxes_.back(), block.grid, row.components, element_bytes,
                                                    *lease, cl::Buffer(memory, true)),
                                       range.all, range.group});
            }
        },
        targets[chosen.front()].arrays(), samples_, all_boxes, part.buffers);
    parts_.push_back(std::move(part));
}

void RequestPlanState::clear() {
    if (last_() != nullptr) device::guarded([&] { device::wait_for(last_); });
    is_whole = false;
    parts_.clear();
    boxes_.clear();
    box_bytes_ = 0;
    samples_ = {};
    statistics = {};
}

std::size_t RequestPlanState::own_bytes() const {
    std::size_t bytes = box_bytes_;
    for_each_output([&](const OutputRow&, const device::BufferPool::Lease& lease) { bytes += lease.bytes(); },
                    samples_);
    for (const Part& part : parts_) bytes += part.plan->own_bytes();
    return bytes;
}

cl::Event RequestPlanState::enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before) {
    if (!device::has_ended(last_)) before.push_back(last_);
    for (Part& part : parts_) {
        last_ = part.plan->enqueue(queue, part.buffers, before, {});
        CommandChain chain(queue, {last_});
        for (Store& store : part.stores) {
            chain.then([&](auto& target, auto* wait, auto* event) {
                target.enqueueNDRangeKernel(store.kernel, cl::NullRange, store.range, store.group, wait, event);
            });
            last_ = chain.last();  // which the next run and the destructor wait for, if what follows fails
        }
        before.assign(1, last_);
    }
    queue.flush();
    return last_;
}

}  // namespace transform

void DistanceTransform::State::plan(transform::RequestPlanState& made, const CallOptions& call) {
    const std::span<const Request> requests = made.requests;
    const device::Context& context = device::context_of(device);
    const std::vector<scan::DeviceTargets> targets = transform::device_targets_of(
        requests, context, [this](const Request& request) { stages->check_inside(request.grid, request.band); });
    std::vector<scan::HostArrays> arrays;
    for (const scan::DeviceTargets& target : targets) arrays.push_back(target.arrays());
    const std::vector<transform::Batch> batches = transform::batches_of(requests, arrays, mesh().box());

    std::vector<transform::RequestPlanState::Block> blocks;
    for (const transform::Batch& batch : batches) {
        const bool in_place = batch.requests.size() == 1 && targets[batch.requests.front()].in_place().has_value();
        const auto limits =
            in_place ? scan::limits_of(context.capabilities()) : scan::stream_limits_of(context.capabilities());
        const std::vector<Grid> slabs = scan::slabs_of(batch.block, limits);
        for (const Grid& slab : slabs) blocks.push_back({&batch, slab, in_place && slabs.size() == 1});
    }

    const std::scoped_lock lock(mutex);
    transform::throw_if_stopped(call);
    transform::Compiling compiling(call, options.log);
    const Stopwatch compile_watch;
    compiling.first_use = transform::ensure_store_tested(device, programs, compiling.watch(1));
    compiling.seconds = compile_watch.seconds();
    made.make_room(blocks, targets);
    transform::Inputs inputs_of_batch;
    double polyhedra_seconds = 0;
    const transform::Batch* batch = nullptr;
    for (const transform::RequestPlanState::Block& block : blocks) {
        const Request& any = requests[block.batch->requests.front()];
        const Outputs outputs = scan::outputs_of(any.targets);
        if (block.batch != batch) {
            batch = block.batch;
            compile(batch->block, any.band, outputs, call.count, compiling);
            const Stopwatch watch;
            inputs_of_batch = inputs(batch->block, any.band, outputs, true);
            polyhedra_seconds += watch.seconds();
        }
        std::vector<Grid> wanted;
        if (batch->requests.size() > 1)
            for (const std::size_t n : batch->requests) wanted.push_back(requests[n].grid);
        transform::Inputs inputs_of_block = inputs_of_batch;
        if (!(block.grid == batch->block))
            stages->select(block.grid, scan::layout_of(block.grid, any.band, sign), inputs_of_block);
        auto of_block =
            make_plan(std::move(inputs_of_block), block.grid, any.band, outputs, wanted, call, compiling, made.pool);
        transform::add_slab(made.statistics, of_block->statistics);
        made.add(block, std::move(of_block), targets, programs);
    }
    device::guarded([&] { context.queue().finish(); });  // errors of the set-up's commands are thrown here
    made.pool->release();
    made.is_whole = true;
    made.statistics.polyhedra_seconds = polyhedra_seconds;
    made.statistics.device_bytes = made.own_bytes();
    report(compiling, made.statistics);
    if (call.statistics != nullptr) *call.statistics = made.statistics;
}

RequestPlan::RequestPlan(std::unique_ptr<transform::RequestPlanState> state) : state_(std::move(state)) {}
RequestPlan::RequestPlan(RequestPlan&&) noexcept = default;
RequestPlan& RequestPlan::operator=(RequestPlan&&) noexcept = default;
RequestPlan::~RequestPlan() = default;

transform::RequestPlanState& RequestPlan::state() const {
    return held_by(state_, "RequestPlan");
}

std::span<const Request> RequestPlan::requests() const {
    return state().requests;
}

const TransformStatistics& RequestPlan::statistics() const {
    return state().statistics;
}

cl_event RequestPlan::enqueue(cl_command_queue queue, std::span<const cl_event> wait_list) {
    transform::RequestPlanState& state = this->state();
    if (!state.is_whole)
        throw Error(ErrorCode::invalid_argument,
                    "the plan's last move() failed, so that it has nothing to compute with; move it again, or make a "
                    "new plan");
    return device::guarded([&] {
        const cl::CommandQueue target =
            queue != nullptr ? cl::CommandQueue(queue, true) : device::context_of(state.device).callers_queue();
        std::vector<cl::Event> events;
        for (cl_event event : wait_list) events.emplace_back(event, true);
        const cl::Event last = state.enqueue(target, std::move(events));
        clRetainEvent(last());
        return last();
    });
}

void RequestPlan::move(const DistanceTransform& transform, std::span<const Grid> grids, const CallOptions& call) {
    transform::RequestPlanState& state = this->state();
    if (!grids.empty() && grids.size() != state.requests.size())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the plan has {} requests, and {} grids are given to move them to; give one for each, "
                                "or none",
                                state.requests.size(), grids.size()));
    state.clear();
    for (std::size_t n = 0; n < grids.size(); ++n) state.requests[n].grid = grids[n];
    transform.state().plan(state, call);
}

RequestPlan DistanceTransform::plan(std::span<const Request> requests, const CallOptions& call) const {
    State& state = this->state();
    auto made = std::make_unique<transform::RequestPlanState>(state.device,
                                                              std::vector<Request>(requests.begin(), requests.end()));
    state.plan(*made, call);
    return RequestPlan(std::move(made));
}

std::size_t DistanceTransform::plan_bytes(std::span<const Request> requests, const CallOptions& call) const {
    return plan(requests, call).statistics().device_bytes;
}

}  // namespace clsdf

#include "calls/sparse_plan_state.hpp"

#include "core/lifetime.hpp"
#include "device/opencl.hpp"
#include "targets/mapped_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace clsdf::calls {

namespace {

std::size_t bricks_of(const Grid& part) {
    return part.sample_count() / brick_samples;
}

/// Bytes of the caller's memory that a run writes.
struct WrittenBytes {
    targets::BufferPlace begin;
    std::size_t bytes;
    std::string name;
};

/// Throws if two have a byte in common.
void refuse_overlap(std::span<const WrittenBytes> written) {
    for (std::size_t n = 0; n < written.size(); ++n)
        for (const WrittenBytes& other : written.first(n)) {
            const WrittenBytes& one = written[n];
            if (one.begin.memory() != other.begin.memory() || one.begin.byte >= other.begin.byte + other.bytes ||
                other.begin.byte >= one.begin.byte + one.bytes)
                continue;
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("{} and {} overlap; give each memory of its own", other.name, one.name));
        }
}

/// Checks a range of so many bytes of the caller's memory. name: begins a sentence.
OrderedTargets::Place place_of(const device::Context& context, const DeviceRange& range, std::size_t bytes,
                               const std::string& name, std::vector<WrittenBytes>& written) {
    if (bytes == 0) return {};
    if (range.memory == nullptr)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} has no memory, and a run writes {} bytes there; give it a buffer", name, bytes));
    const cl::Buffer memory(range.memory, true);
    targets::require_buffer(context, memory, name);
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_READ_ONLY) != 0)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} is a buffer made with CL_MEM_READ_ONLY; kernels write to it, so make it with "
                                "CL_MEM_READ_WRITE",
                                name));
    if (range.offset % sizeof(std::uint64_t) != 0)
        throw Error(
            ErrorCode::invalid_argument,
            fmt::format("{} begins at byte {} of its buffer; let it begin at a multiple of 8", name, range.offset));
    const std::size_t size = memory.getInfo<CL_MEM_SIZE>();
    if (range.offset > size || size - range.offset < bytes)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} needs {} bytes from byte {} on, and its buffer has {}; give it a larger one", name,
                                bytes, range.offset, size));
    written.push_back({targets::place_of(range.memory, range.offset), bytes, name});
    return {memory, range.offset};
}

}  // namespace

SparsePlanState::SparsePlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in)
    : device(std::move(device_in)), pool(std::move(pool_in)) {}

SparsePlanState::~SparsePlanState() {
    if (runs_.wait() == CL_SUCCESS) return;
    keep_for_good(planned_);
    keep_for_good(listed_);
}

void SparsePlanState::divide(const engine::Job& job) {
    batch_ = Batch{.job = job, .arrays = targets::arrays_for(job.outputs)};
    slabs_.clear();
    for (const Grid& part : engine::sparse_slabs_of(job.grid)) slabs_.push_back({&*batch_, part});
}

void SparsePlanState::make_room() {
    std::size_t most = 0;
    for (const Slab& slab : slabs_) most = std::max(most, bricks_of(slab.grid));
    listed_.emplace(*pool, std::clamp<std::size_t>(room.bricks, 1, most), most, batch_->arrays);
}

void SparsePlanState::add(std::unique_ptr<engine::GridPlan> plan, const engine::Programs& programs) {
    BrickOrder order({device::context_of(device), pool, programs}, plan->job.layout, plan->marks(), *listed_);
    planned_.push_back({std::move(plan), std::move(order)});
}

void SparsePlanState::complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh) {
    CallStatistics statistics = call;
    for (const PlannedSlab& planned : planned_) add_slab(statistics, planned.plan->statistics);
    statistics.device_bytes = own_bytes(kept_mesh);
    published = statistics.published();
    is_whole = true;
}

void SparsePlanState::clear() {
    device::guarded([&] {
        if (const cl_int code = runs_.wait(); code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
    });
    is_whole = false;
    planned_.clear();
    listed_.reset();
}

std::size_t SparsePlanState::own_bytes(const engine::KeptMesh& kept_mesh) const {
    std::size_t bytes = listed_->bytes();
    engine::Inputs counted;  // the slabs share them
    for (const PlannedSlab& planned : planned_) {
        bytes += planned.plan->own_bytes() + planned.order.bytes();
        engine::Inputs inputs = planned.plan->inputs;
        if (inputs.records == counted.records) inputs.records = nullptr;
        if (inputs.sweep_mesh == counted.sweep_mesh) inputs.sweep_mesh = nullptr;
        bytes += engine::bytes_beside(kept_mesh, inputs);
        counted = planned.plan->inputs;
    }
    return bytes;
}

OrderedTargets SparsePlanState::targets_of(const SparseDeviceTargets& given) const {
    const device::Context& context = device::context_of(device);
    std::vector<WrittenBytes> written;
    OrderedTargets to;
    to.room = room;
    to.counts = place_of(context, given.counts, sizeof(DeviceSparseCounts), "the memory of the counts", written);
    to.bricks = place_of(context, given.bricks, room.bricks * sizeof(Index3), "the array of bricks", written);
    to.inside = place_of(context, given.inside, room.runs * sizeof(BrickRun), "the array of runs", written);
    if (room.bricks > 0) {
        const targets::DeviceTargets checked(given.values, targets::row_of(room.bricks * brick_samples), context);
        for_each_output(
            [&](const OutputInfo& row, const targets::HostArray& expected, const targets::HostArray& array,
                const OutputArray& target, OrderedTargets::Place& place) {
                if (array.is_wanted != expected.is_wanted)
                    throw Error(ErrorCode::invalid_argument,
                                expected.is_wanted
                                    ? fmt::format("the plan computes the output {0}, and {0} has no target; give it "
                                                  "memory, or plan without",
                                                  row.name)
                                    : fmt::format("the output {0} has a target, and the plan was made without; leave "
                                                  "the target out, or make the plan with {0}",
                                                  row.name));
                if (!array.is_wanted) return;
                if (may_be_double(row) && array.in_double)
                    throw Error(ErrorCode::unsupported,
                                fmt::format("the target of the output {} has doubles, and a sparse field has floats; "
                                            "give it floats",
                                            row.name));
                if (target.strides[0] != static_cast<std::ptrdiff_t>(row.sample_bytes()) ||
                    (row.components > 1 &&
                     target.component_stride != static_cast<std::ptrdiff_t>(bytes_of(target.type))))
                    throw Error(ErrorCode::unsupported,
                                fmt::format("the target of the output {} has strides; give it a packed array, of 512 "
                                            "samples for each brick",
                                            row.name));
                place = {cl::Buffer(target.device, true), target.offset};
                written.push_back({targets::place_of(target.device, target.offset),
                                   room.bricks * brick_samples * row.sample_bytes(),
                                   fmt::format("the target of the output {}", row.name)});
            },
            batch_->arrays, checked.arrays, checked.targets, to.values);
    }
    refuse_overlap(written);
    return to;
}

cl::Event SparsePlanState::enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before,
                                   const OrderedTargets& targets) {
    device::Context& context = device::context_of(device);
    if (queue() == context.queue()() && !before.empty()) context.add_waiting_run();
    engine::CommandChain& chain = runs_.begin(queue, std::move(before));
    chain.then_fill(*listed_->totals, 2 * sizeof(cl_ulong));
    engine::OutputBuffers buffers;
    for_each_output(
        [](const OutputInfo&, const device::BufferPool::Lease& lease, cl::Buffer& buffer) { buffer = *lease; },
        listed_->values, buffers);
    buffers.listed = *listed_->listed;
    std::array<cl_uint, CLSDF_STORED> head{};
    head[CLSDF_STORED_ROOM] = static_cast<cl_uint>(listed_->room);
    for (PlannedSlab& planned : planned_) {
        chain.then([&](auto& to, auto* wait, auto* event) {
            to.enqueueFillBuffer(*listed_->listed, head, 0, sizeof head, wait, event);
        });
        planned.plan->enqueue(chain, buffers, {});
        planned.order.enqueue(chain, targets);
    }
    queue.flush();
    return chain.last();
}

}  // namespace clsdf::calls

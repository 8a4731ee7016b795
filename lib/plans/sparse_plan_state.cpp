#include "plans/sparse_plan_state.hpp"

#include "core/refuse.hpp"
#include "device/opencl.hpp"
#include "targets/mapped_memory.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace clsdf::plans {

namespace {

std::size_t bricks_of(const Grid& part) {
    return part.sample_count() / brick_samples;
}

/// Checks a range of so many bytes of the caller's memory. name: begins a sentence.
targets::OrderedTargets::Place place_of(const device::Context& context, const DeviceRange& range, std::size_t bytes,
                                        const char* name, std::vector<targets::WrittenArray>& written) {
    if (bytes == 0) return {};
    const cl::Buffer memory = targets::checked_range(context, range, bytes, sizeof(std::uint64_t), name);
    const targets::BufferPlace begin = targets::place_of(range.memory, range.offset);
    written.push_back({.memory = begin.memory(), .first = begin.byte, .width = bytes, .name = name});
    return {memory, range.offset};
}

}  // namespace

void SparsePlanState::divide(const engine::Job& job) {
    made_.batch = Batch{.job = job, .arrays = targets::arrays_for(job.outputs)};
    for (const Grid& part : engine::sparse_slabs_of(job.grid)) made_.slabs.push_back({&*made_.batch, part});
}

void SparsePlanState::clear() {
    made_.planned.clear();
    made_.listed.reset();
}

void SparsePlanState::make_room() {
    std::size_t most = 0;
    for (const Slab& slab : made_.slabs) most = std::max(most, bricks_of(slab.grid));
    made_.listed.emplace(*pool, std::clamp<std::size_t>(asked().room.bricks, 1, most), most, made_.batch->arrays);
}

void SparsePlanState::add(std::unique_ptr<engine::GridPlan> plan, const engine::Programs& programs) {
    targets::BrickStore store({context(), pool, programs}, plan->job.layout, plan->marks(), *made_.listed);
    made_.planned.push_back({std::move(plan), std::move(store)});
}

CallStatistics SparsePlanState::complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh) const {
    CallStatistics statistics = with_slabs(call, made_.planned, kept_mesh);
    statistics.device_bytes += made_.listed->bytes();
    for (const PlannedBricks::PlannedSlab& planned : made_.planned) statistics.device_bytes += planned.store.bytes();
    return statistics;
}

targets::OrderedTargets SparsePlanState::targets_of(const SparseDeviceTargets& given) const {
    const device::Context& context = this->context();
    const SparseCounts& room = asked().room;
    std::vector<targets::WrittenArray> written;
    targets::OrderedTargets to;
    to.room = room;
    to.counts = place_of(context, given.counts, sizeof(DeviceSparseCounts), "the memory of the counts", written);
    to.bricks = place_of(context, given.bricks, room.bricks * sizeof(Index3), "the array of bricks", written);
    to.inside = place_of(context, given.inside, room.runs * sizeof(BrickRun), "the array of runs", written);
    if (room.bricks > 0) {
        const targets::DeviceTargets checked(given.values, targets::row_of(room.bricks * brick_samples), context);
        for_each_output(
            [&](const OutputInfo& row, const targets::HostArray& expected, const targets::HostArray& array,
                const OutputArray& target, targets::OrderedTargets::Place& place) {
                require_target(row, expected.is_wanted, array.is_wanted);
                if (!array.is_wanted) return;
                if (may_be_double(row) && array.in_double)
                    refuse_unsupported(
                        "the target of the output {} has doubles, and a sparse field has floats; "
                        "give it floats",
                        row.name);
                if (target.strides[0] != static_cast<std::ptrdiff_t>(row.sample_bytes()) ||
                    (row.components > 1 &&
                     target.component_stride != static_cast<std::ptrdiff_t>(bytes_of(target.type))))
                    refuse_unsupported(
                        "the target of the output {} has strides; give it a packed array, of 512 "
                        "samples for each brick",
                        row.name);
                place = {cl::Buffer(target.device, true), target.offset};
            },
            made_.batch->arrays, checked.arrays, checked.targets, to.values);
        checked.add_written(0, written);
    }
    targets::refuse_overlap(written);
    return to;
}

void SparsePlanState::enqueue(const RunOptions& options, const SparseDeviceTargets& given) {
    const targets::OrderedTargets targets = targets_of(given);
    const targets::ListedBricks& listed = *made_.listed;
    engine::OutputBuffers buffers;
    for_each_output(
        [](const OutputInfo&, const device::BufferPool::Lease& lease, cl::Buffer& buffer) { buffer = *lease; },
        listed.values, buffers);
    buffers.listed = *listed.listed;
    std::array<cl_uint, CLSDF_STORED> head{};
    head[CLSDF_STORED_ROOM] = static_cast<cl_uint>(listed.room);
    run(options, [&](engine::CommandChain& chain) {
        chain.then_fill(*listed.totals, 2 * sizeof(cl_ulong));
        for (PlannedBricks::PlannedSlab& planned : made_.planned) {
            chain.then([&](auto& to, auto* wait, auto* event) {
                to.enqueueFillBuffer(*listed.listed, head, 0, sizeof head, wait, event);
            });
            planned.plan->enqueue(chain, buffers, {});
            planned.store.enqueue(chain, targets);
        }
    });
}

}  // namespace clsdf::plans

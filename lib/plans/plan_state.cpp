#include "plans/plan_state.hpp"

#include "core/refuse.hpp"
#include "device/opencl.hpp"
#include "launch/programs.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace clsdf::plans {

namespace {

/// A slab that is a part of a batch has no buffer of its own among the targets.
bool is_in_place(const Slab& slab) {
    return slab.batch->in_place && slab.is_whole();
}

}  // namespace

void PlanState::divide(std::span<const engine::Job> jobs, std::span<const targets::DeviceTargets> targets,
                       const Box& box) {
    const device::Context::Capabilities& capabilities = context().capabilities();
    const std::size_t largest = capabilities.largest_allocation;
    made_.batches = batches_of(jobs, targets, box);
    made_.slabs = slabs_of(made_.batches, engine::stream_limits_of(capabilities), {largest, largest, largest});
}

bool PlanState::has_copies() const {
    return !std::ranges::all_of(made_.slabs, is_in_place);
}

void PlanState::clear() {
    made_.planned.clear();
    made_.samples = {};
}

void PlanState::make_room() {
    PerOutput<std::size_t> most{};
    for (const Slab& slab : made_.slabs) {
        if (is_in_place(slab)) continue;
        for_each_output(
            [&](const OutputInfo& row, const targets::HostArray& array, std::size_t& bytes) {
                if (!array.is_wanted) return;
                bytes = std::max(bytes, slab.grid.sample_count() * sample_bytes(row, array.in_double));
            },
            slab.batch->arrays, most);
    }
    for_each_output(
        [&](const OutputInfo&, std::size_t bytes, device::BufferPool::Lease& lease) {
            if (bytes > 0) lease = pool->lease(bytes, "samples of a plan's slabs");
        },
        most, made_.samples);
}

void PlanState::add(const Slab& slab, std::unique_ptr<engine::GridPlan> plan,
                    std::span<const targets::DeviceTargets> targets, const engine::Programs& programs) {
    const targets::DeviceTargets& first = targets[slab.batch->requests.front()];
    PlannedSlab planned{slab, std::move(plan), first.targets};
    if (is_in_place(slab)) {
        planned.buffers = *first.in_place;
        made_.planned.push_back(std::move(planned));
        return;
    }
    const cl::Program program = programs.store.get();
    PerOutput<std::vector<targets::TargetBox>> all_places = places_of(planned, targets);
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, const device::BufferPool::Lease& lease,
            std::vector<targets::TargetBox>& places, std::optional<targets::BoxStore>& store, cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            buffer = *lease;
            if (array.in_double) planned.buffers.in_double |= bit_of(row);
            const targets::StoredElements elements{row.components, sample_bytes(row, array.in_double) / row.components};
            if (!places.empty()) store.emplace(context(), program, slab.grid, elements, *lease, std::move(places));
        },
        slab.batch->arrays, made_.samples, all_places, planned.stores, planned.buffers);
    made_.planned.push_back(std::move(planned));
}

PerOutput<std::vector<targets::TargetBox>> PlanState::places_of(const PlannedSlab& planned,
                                                                std::span<const targets::DeviceTargets> targets) const {
    PerOutput<std::vector<targets::TargetBox>> all_places;
    const Batch& batch = *planned.slab.batch;
    for (const std::size_t n : batch.requests)
        for_each_output(
            [&](const OutputInfo&, const OutputArray& target, const targets::HostArray& array,
                std::vector<targets::TargetBox>& places) {
                if (!array.is_wanted) return;
                if (const auto box = targets::stored_box(planned.slab.grid, asked().requests[n].grid, target))
                    places.push_back({target.device, *box});
            },
            targets[n].targets, batch.arrays, all_places);
    // A launch stores what goes to one buffer: the buffers in the order of the requests.
    for_each_output(
        [](const OutputInfo&, std::vector<targets::TargetBox>& places) {
            std::map<cl_mem, std::size_t> numbers;
            for (const targets::TargetBox& place : places) numbers.emplace(place.memory, numbers.size());
            std::ranges::stable_sort(places, {},
                                     [&](const targets::TargetBox& place) { return numbers.at(place.memory); });
        },
        all_places);
    return all_places;
}

void PlanState::check(const PlannedSlab& planned, const targets::DeviceTargets& target) const {
    const bool in_place = is_in_place(planned.slab);
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& expected, const targets::HostArray& given,
            const OutputArray& like, const OutputArray& other) {
            require_target(row, expected.is_wanted, given.is_wanted);
            // Distances in double are other work.
            const bool is_fixed = !in_place || row.output == Output::distance;
            if (is_fixed && other.type != like.type)
                refuse_unsupported(
                    "the target of the output {} has {}s, another type of elements than planned; "
                    "make the plan of a request with such a target",
                    row.name, name_of(other.type));
        },
        planned.slab.batch->arrays, target.arrays, planned.like, target.targets);
    if (in_place && !target.in_place)
        refuse_unsupported(
            "the target of the output {}, but this plan writes to its targets directly and cannot copy; "
            "make it of a request with such a target",
            target.why_not_in_place);
}

std::vector<targets::DeviceTargets> PlanState::targets_of(std::span<const OutputTargets> given) const {
    const std::vector<Request>& requests = asked().requests;
    if (given.size() != requests.size())
        refuse(
            "the plan has {} requests, and the targets of {} are given; give each request its "
            "targets",
            requests.size(), given.size());
    std::vector<Request> others = requests;
    for (std::size_t n = 0; n < given.size(); ++n) others[n].targets = given[n];
    auto targets = plans::targets_of(others, [&](const Request& request) {
        return targets::DeviceTargets(request.targets, request.grid, context());
    });
    for (const PlannedSlab& planned : made_.planned)
        for (const std::size_t n : planned.slab.batch->requests)
            for_request(n, requests.size(), [&] { check(planned, targets[n]); });
    return targets;
}

const CallStatistics& PlanState::complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh) {
    statistics = with_slabs(call, made_.planned, kept_mesh);
    for_each_output(
        [&](const OutputInfo&, const device::BufferPool::Lease& lease) { statistics.device_bytes += lease.bytes(); },
        made_.samples);
    for (const PlannedSlab& planned : made_.planned)
        for_each_output(
            [&](const OutputInfo&, const std::optional<targets::BoxStore>& store) {
                statistics.device_bytes += store ? store->bytes() : 0;
            },
            planned.stores);
    return statistics;
}

void PlanState::read_counters() {
    for (const auto count : device_counts) statistics.*count = 0;
    for (const PlannedSlab& planned : made_.planned) {
        planned.plan->read_back(context().queue());
        for (const auto count : device_counts) statistics.*count += planned.plan->statistics.*count;
    }
}

void PlanState::enqueue(const RunOptions& options) {
    run(options, [&](engine::CommandChain& chain) { enqueue_slabs(chain, {}); });
}

void PlanState::enqueue(const RunOptions& options, std::span<const OutputTargets> given) {
    const std::vector<targets::DeviceTargets> targets = targets_of(given);
    run(options, [&](engine::CommandChain& chain) { enqueue_slabs(chain, targets); });
}

void PlanState::enqueue_slabs(engine::CommandChain& chain, std::span<const targets::DeviceTargets> targets) {
    for (PlannedSlab& planned : made_.planned) {
        if (is_in_place(planned.slab)) {
            const std::size_t first = planned.slab.batch->requests.front();
            planned.plan->enqueue(chain, targets.empty() ? planned.buffers : *targets[first].in_place, {});
            continue;
        }
        planned.plan->enqueue(chain, planned.buffers, {});
        PerOutput<std::vector<targets::TargetBox>> all_places;
        if (!targets.empty()) all_places = places_of(planned, targets);
        for_each_output(
            [&](const OutputInfo&, std::optional<targets::BoxStore>& store,
                const std::vector<targets::TargetBox>& places) {
                if (store) store->enqueue(chain, places);
            },
            planned.stores, all_places);
    }
}

}  // namespace clsdf::plans

#include "calls/plan_state.hpp"

#include "core/lifetime.hpp"
#include "device/opencl.hpp"
#include "launch/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace clsdf::calls {

namespace {

/// A slab that is a part of a batch has no buffer of its own among the targets.
bool is_in_place(const Slab& slab) {
    return slab.batch->in_place && slab.is_whole();
}

}  // namespace

PlanState::PlanState(Device device_in, std::shared_ptr<device::BufferPool> pool_in, bool is_own_pool)
    : device(std::move(device_in)), has_own_pool(is_own_pool), pool(std::move(pool_in)) {}

PlanState::~PlanState() {
    if (runs_.wait() == CL_SUCCESS) return;
    keep_for_good(samples_);
    keep_for_good(planned_);
}

void PlanState::divide(std::span<const engine::Job> jobs, std::span<const targets::DeviceTargets> targets,
                       const Box& box) {
    const device::Context::Capabilities& capabilities = device::context_of(device).capabilities();
    const std::size_t largest = capabilities.largest_allocation;
    batches_ = batches_of(jobs, targets, box);
    slabs_ = slabs_of(batches_, engine::stream_limits_of(capabilities), {largest, largest, largest});
}

bool PlanState::has_copies() const {
    return !std::ranges::all_of(slabs_, is_in_place);
}

void PlanState::make_room() {
    PerOutput<std::size_t> most{};
    for (const Slab& slab : slabs_) {
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
        most, samples_);
}

void PlanState::add(const Slab& slab, std::unique_ptr<engine::GridPlan> plan,
                    std::span<const targets::DeviceTargets> targets, const engine::Programs& programs) {
    const targets::DeviceTargets& first = targets[slab.batch->requests.front()];
    PlannedSlab planned{slab, std::move(plan), first.targets};
    if (is_in_place(slab)) {
        planned.buffers = *first.in_place;
        planned_.push_back(std::move(planned));
        return;
    }
    device::Context& context = device::context_of(device);
    const cl::Program program = programs.store.get();
    PerOutput<std::vector<targets::TargetBox>> all_places = places_of(planned, targets);
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, const device::BufferPool::Lease& lease,
            std::vector<targets::TargetBox>& places, std::optional<targets::BoxStore>& store, cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            buffer = *lease;
            if (array.in_double) planned.buffers.in_double |= bit_of(row);
            const targets::StoredElements elements{row.components, sample_bytes(row, array.in_double) / row.components};
            if (!places.empty()) store.emplace(context, program, slab.grid, elements, *lease, std::move(places));
        },
        slab.batch->arrays, samples_, all_places, planned.stores, planned.buffers);
    planned_.push_back(std::move(planned));
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
                if (const auto box = targets::stored_box(planned.slab.grid, requests[n].grid, target))
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
            if (given.is_wanted != expected.is_wanted)
                throw Error(ErrorCode::invalid_argument,
                            expected.is_wanted
                                ? fmt::format("the plan computes the output {0}, and {0} has no target; give it "
                                              "memory, or plan without",
                                              row.name)
                                : fmt::format("the output {0} has a target, and the plan was made without; "
                                              "leave the target out, or make the plan with {0}",
                                              row.name));
            // Distances in double are other work.
            const bool is_fixed = !in_place || row.output == Output::distance;
            if (is_fixed && other.type != like.type)
                throw Error(ErrorCode::unsupported,
                            fmt::format("the target of the output {} has {}s, another type of elements than planned; "
                                        "make the plan of a request with such a target",
                                        row.name, name_of(other.type)));
        },
        planned.slab.batch->arrays, target.arrays, planned.like, target.targets);
    if (in_place && !target.in_place)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("the target of the output {}, but this plan writes to its targets directly and cannot copy; "
                        "make it of a request with such a target",
                        target.why_not_in_place));
}

std::vector<targets::DeviceTargets> PlanState::targets_of(std::span<const OutputTargets> given) const {
    if (given.size() != requests.size())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the plan has {} requests, and the targets of {} are given; give each request its "
                                "targets",
                                requests.size(), given.size()));
    std::vector<Request> others = requests;
    for (std::size_t n = 0; n < given.size(); ++n) others[n].targets = given[n];
    auto targets = calls::targets_of(others, [&](const Request& request) {
        return targets::DeviceTargets(request.targets, request.grid, device::context_of(device));
    });
    for (const PlannedSlab& planned : planned_)
        for (const std::size_t n : planned.slab.batch->requests)
            for_request(n, requests.size(), [&] { check(planned, targets[n]); });
    return targets;
}

void PlanState::complete(const CallStatistics& call, const engine::KeptMesh& kept_mesh) {
    statistics = call;
    for (const PlannedSlab& planned : planned_) add_slab(statistics, planned.plan->statistics);
    statistics.device_bytes = own_bytes(kept_mesh);
    published = statistics.published();
    is_whole = true;
}

void PlanState::clear() {
    device::guarded([&] {
        if (const cl_int code = runs_.wait(); code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
    });
    is_whole = false;
    planned_.clear();
    samples_ = {};
    statistics = {};
}

std::size_t PlanState::own_bytes(const engine::KeptMesh& kept_mesh) const {
    std::size_t bytes = 0;
    for_each_output([&](const OutputInfo&, const device::BufferPool::Lease& lease) { bytes += lease.bytes(); },
                    samples_);
    engine::Inputs counted;  // the slabs of a batch follow one another, and share them
    for (const PlannedSlab& planned : planned_) {
        bytes += planned.plan->own_bytes();
        engine::Inputs inputs = planned.plan->inputs;
        if (inputs.records == counted.records) inputs.records = nullptr;
        if (inputs.sweep_mesh == counted.sweep_mesh) inputs.sweep_mesh = nullptr;
        bytes += engine::bytes_beside(kept_mesh, inputs);
        counted = planned.plan->inputs;
        for_each_output([&](const OutputInfo&,
                            const std::optional<targets::BoxStore>& store) { bytes += store ? store->bytes() : 0; },
                        planned.stores);
    }
    return bytes;
}

void PlanState::enqueue_stores(PlannedSlab& planned, engine::CommandChain& chain,
                               std::span<const targets::DeviceTargets> targets) const {
    if (is_in_place(planned.slab)) return;
    PerOutput<std::vector<targets::TargetBox>> all_places;
    if (!targets.empty()) all_places = places_of(planned, targets);
    for_each_output(
        [&](const OutputInfo&, std::optional<targets::BoxStore>& store, const std::vector<targets::TargetBox>& places) {
            if (store) store->enqueue(chain, places);
        },
        planned.stores, all_places);
}

void PlanState::read_counters() {
    for (const auto count : device_counts) statistics.*count = 0;
    for (const PlannedSlab& planned : planned_) {
        planned.plan->read_back(device::context_of(device).queue());
        for (const auto count : device_counts) statistics.*count += planned.plan->statistics.*count;
    }
}

cl::Event PlanState::enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before,
                             std::span<const targets::DeviceTargets> targets) {
    device::Context& context = device::context_of(device);
    if (queue() == context.queue()() && !before.empty()) context.add_waiting_run();
    engine::CommandChain& chain = runs_.begin(queue, std::move(before));
    if (planned_.empty())
        chain.then([](const auto& to, auto* wait, auto* event) { to.enqueueMarkerWithWaitList(wait, event); });
    for (PlannedSlab& planned : planned_) {
        const bool has_other = is_in_place(planned.slab) && !targets.empty();
        const std::size_t first = planned.slab.batch->requests.front();
        planned.plan->enqueue(chain, has_other ? *targets[first].in_place : planned.buffers, {});
        enqueue_stores(planned, chain, targets);
    }
    queue.flush();
    return chain.last();
}

}  // namespace clsdf::calls

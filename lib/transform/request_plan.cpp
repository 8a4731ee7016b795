#include "transform/request_plan.hpp"

#include "core/lifetime.hpp"
#include "device/opencl.hpp"
#include "scan/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace clsdf::transform {

namespace {

template <typename>
using BytesOf = std::size_t;
/// The boxes that go to each of the caller's buffers.
template <typename>
using BoxesOf = std::map<cl_mem, std::vector<StoredBox>>;

}  // namespace

RequestPlanState::RequestPlanState(Device device_in, std::vector<Request> requests_in,
                                   std::shared_ptr<device::BufferPool> pool_in, bool is_own_pool)
    : device(std::move(device_in)),
      has_own_pool(is_own_pool),
      pool(std::move(pool_in)),
      requests(std::move(requests_in)) {}

RequestPlanState::~RequestPlanState() {
    if (runs_.wait() == CL_SUCCESS) return;
    // The plans of the parts cannot tell either, and keep what is theirs.
    keep_for_good(samples_);
    for (Part& part : parts_) keep_for_good(part.stores);
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
    planned_ = targets.front().targets();
    if (block.in_place) {
        parts_.push_back({std::move(plan), true, *targets[chosen.front()].in_place(), {}});
        return;
    }
    const device::Context& context = device::context_of(device);
    const cl::Program program = programs.store(device::context_of(device));
    Part part{std::move(plan), false, {}, {}};
    PerOutput<BoxesOf> all_boxes;
    for (const std::size_t n : chosen)
        for_each_output(
            [&](const OutputRow&, const OutputTarget& target, const HostArray& array, auto& boxes) {
                if (!array.is_wanted) return;
                if (const auto box = stored_box(block.grid, requests[n].grid, target))
                    boxes[target.device].push_back(*box);
            },
            targets[n].targets(), targets[n].arrays(), all_boxes);
    for_each_output(
        [&](const OutputRow& row, const OutputTarget& any, const HostArray& array,
            const device::BufferPool::Lease& lease, const auto& boxes, cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            buffer = *lease;
            if (array.in_double) part.buffers.in_double |= row.bit;
            const StoredElements elements{row.components, row.sample_bytes(array.in_double) / row.components,
                                          is_widened(row, any)};
            for (const auto& [memory, of_memory] : boxes)
                part.stores.emplace_back(context, program, block.grid, elements, *lease, memory, of_memory);
        },
        targets[chosen.front()].targets(), targets[chosen.front()].arrays(), samples_, all_boxes, part.buffers);
    parts_.push_back(std::move(part));
}

OutputBuffers RequestPlanState::set_targets(const OutputTargets& targets) {
    const Grid& grid = requests.front().grid;
    const DeviceTargets given(targets, grid, device::context_of(device));
    const bool needs_copy = std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return !part.in_place; });
    for_each_output(
        [&](const OutputRow& row, const OutputTarget& planned, const OutputTarget& target, const HostArray& array) {
            const bool is_planned = planned.element != OutputTarget::Element::automatic;
            if (array.is_wanted != is_planned)
                throw Error(ErrorCode::invalid_argument,
                            is_planned ? fmt::format("the plan computes the output {0}, and {0} has no target; give it "
                                                     "memory, or plan without",
                                                     row.name)
                                       : fmt::format("{0} has a target, and the plan was made without; plan with "
                                                     "Outputs{{.{0} = true}}",
                                                     row.name));
            if (needs_copy && target.element != planned.element)
                throw Error(ErrorCode::unsupported,
                            fmt::format("the target of the output {} has other elements than the plan was made for, "
                                        "and the plan copies; make a plan of a request with such a target",
                                        row.name));
        },
        planned_, given.targets(), given.arrays());
    if (!needs_copy) {
        if (given.in_place()) return *given.in_place();
        throw Error(ErrorCode::unsupported,
                    fmt::format("the target of the output {}, and the plan was made without memory to copy from; make "
                                "it with DistanceTransform::plan(request)",
                                given.why_not_in_place()));
    }
    for (Part& part : parts_) {
        auto store = part.stores.begin();
        for_each_output(
            [&](const OutputRow&, const OutputTarget& target, const HostArray& array) {
                if (array.is_wanted) (store++)->move(target.device, *stored_box(part.plan->grid, grid, target));
            },
            given.targets(), given.arrays());
    }
    return {};
}

void RequestPlanState::clear() {
    device::guarded([&] {
        if (const cl_int code = runs_.wait(); code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
    });
    is_whole = false;
    parts_.clear();
    samples_ = {};
    statistics = {};
}

std::size_t RequestPlanState::own_bytes() const {
    std::size_t bytes = 0;
    for_each_output([&](const OutputRow&, const device::BufferPool::Lease& lease) { bytes += lease.bytes(); },
                    samples_);
    for (const Part& part : parts_) {
        bytes += part.plan->own_bytes();
        for (const BoxStore& store : part.stores) bytes += store.bytes();
    }
    return bytes;
}

cl::Event RequestPlanState::enqueue(const cl::CommandQueue& queue, std::vector<cl::Event> before,
                                    const OutputBuffers* in_place) {
    if (const cl::Event latest = runs_.latest(); latest() != nullptr) before.push_back(latest);
    cl::Event last;
    std::vector<cl::Event> stores;
    try {
        if (parts_.empty()) queue.enqueueMarkerWithWaitList(before.empty() ? nullptr : &before, &last);
        for (Part& part : parts_) {
            const cl::Event earlier = part.plan->latest();
            try {
                last = part.plan->enqueue(queue, part.in_place && in_place != nullptr ? *in_place : part.buffers,
                                          before, {});
            } catch (...) {
                const cl::Event begun = part.plan->latest();
                if (begun() != nullptr && begun() != earlier()) last = begun;
                throw;
            }
            CommandChain chain(queue, {last});
            try {
                for (BoxStore& store : part.stores) store.enqueue(chain);
            } catch (...) {
                last = chain.last();
                stores.insert(stores.end(), chain.events().begin(), chain.events().end());
                throw;
            }
            last = chain.last();
            stores.insert(stores.end(), chain.events().begin(), chain.events().end());
            before.assign(1, last);
        }
    } catch (...) {
        // The next run must follow: all parts share memory. `last` follows all other commands of this run.
        if (last() != nullptr) runs_.add(last, std::move(stores));
        throw;
    }
    runs_.add(last, std::move(stores));
    queue.flush();
    return last;
}

}  // namespace clsdf::transform

#include "transform/request_plan.hpp"

#include "core/lifetime.hpp"
#include "core/stopwatch.hpp"
#include "device/opencl.hpp"
#include "scan/layout_of.hpp"
#include "scan/programs.hpp"
#include "scan/slabs.hpp"
#include "transform/stored_boxes.hpp"
#include "transform/transform_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace clsdf {

namespace transform {

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
    if (device::has_ended(last_)) return;
    const cl_int code = clWaitForEvents(1, &last_());
    if (code == CL_SUCCESS || code == CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) return;
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
    if (last_() != nullptr) device::guarded([&] { device::wait_for(last_); });
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
    if (!device::has_ended(last_)) before.push_back(last_);
    if (parts_.empty()) queue.enqueueMarkerWithWaitList(before.empty() ? nullptr : &before, &last_);
    for (Part& part : parts_) {
        last_ = part.plan->enqueue(queue, part.in_place && in_place != nullptr ? *in_place : part.buffers, before, {});
        CommandChain chain(queue, {last_});
        for (BoxStore& store : part.stores) {
            store.enqueue(chain);
            last_ = chain.last();  // which the next run and the destructor wait for, if what follows fails
        }
        before.assign(1, last_);
    }
    queue.flush();
    return last_;
}

namespace {

/// For the caller, who releases the event.
cl_event enqueue_run(RequestPlanState& state, cl_command_queue queue, std::span<const cl_event> wait_list,
                     const OutputBuffers* in_place) {
    const cl::CommandQueue target =
        queue != nullptr ? cl::CommandQueue(queue, true) : device::context_of(state.device).callers_queue();
    std::vector<cl::Event> events;
    for (cl_event event : wait_list) events.emplace_back(event, true);
    const cl::Event last = state.enqueue(target, std::move(events), in_place);
    clRetainEvent(last());
    return last();
}

}  // namespace

}  // namespace transform

void DistanceTransform::State::plan(transform::RequestPlanState& made, std::vector<Request> requests,
                                    const CallOptions& call) {
    const std::vector<scan::DeviceTargets> targets = transform::device_targets_of(
        requests, device::context_of(device),
        [this](const Request& request) { stages->check(request.grid, request.band, sign); });
    std::swap(made.requests, requests);
    made.is_whole = false;
    try {
        plan(made, targets, call);
    } catch (...) {
        std::swap(made.requests, requests);
        made.clear();
        made.pool->release();
        throw;
    }
}

void DistanceTransform::State::plan(transform::RequestPlanState& made, std::span<const scan::DeviceTargets> targets,
                                    const CallOptions& call) {
    const std::span<const Request> requests = made.requests;
    const device::Context& context = device::context_of(device);
    std::vector<scan::HostArrays> arrays;
    for (const scan::DeviceTargets& target : targets) arrays.push_back(target.arrays());
    const std::vector<transform::Batch> batches = transform::batches_of(requests, arrays, mesh().box());

    std::vector<transform::RequestPlanState::Block> blocks;
    for (const transform::Batch& batch : batches) {
        const bool in_place = batch.requests.size() == 1 && targets[batch.requests.front()].in_place().has_value();
        const std::size_t largest = context.capabilities().largest_allocation;
        const auto limits =
            in_place ? scan::SlabLimits{largest, largest, largest} : scan::stream_limits_of(context.capabilities());
        const std::vector<Grid> slabs = scan::slabs_of(batch.block, limits);
        for (const Grid& slab : slabs) blocks.push_back({&batch, slab, in_place && slabs.size() == 1});
    }

    const KeepsBudget keeps_budget{*this};
    const std::scoped_lock lock(mutex);
    transform::throw_if_stopped(call);
    transform::Compiling compiling(call, options.log);
    if (!std::all_of(blocks.begin(), blocks.end(), [](const auto& block) { return block.in_place; })) {
        const Stopwatch compile_watch;
        compiling.first_use = transform::ensure_store_tested(device, programs, compiling.watch(1));
        compiling.seconds = compile_watch.seconds();
    }
    made.sign = sign;
    double polyhedra_seconds = 0;
    std::size_t bytes_of_inputs = 0;  // that the transform does not keep
    bool is_retry = false;
    const auto make = [&] {
        made.clear();
        if (std::exchange(is_retry, true) && made.has_own_pool) made.pool->release();
        made.make_room(blocks, targets);
        polyhedra_seconds = 0;
        bytes_of_inputs = 0;
        transform::Inputs inputs_of_batch;
        const transform::Batch* batch = nullptr;
        for (const transform::RequestPlanState::Block& block : blocks) {
            const Request& any = requests[block.batch->requests.front()];
            const Outputs outputs = scan::outputs_of(targets[block.batch->requests.front()].arrays());
            if (block.batch != batch) {
                batch = block.batch;
                compile(batch->block, any.band, outputs, call.count, compiling);
                const Stopwatch watch;
                inputs_of_batch = inputs(batch->block, any.band, outputs, true);
                polyhedra_seconds += watch.seconds();
                bytes_of_inputs += stages->bytes_beside(inputs_of_batch);
            }
            std::vector<Grid> wanted;
            if (batch->requests.size() > 1)
                for (const std::size_t n : batch->requests) wanted.push_back(requests[n].grid);
            transform::Inputs inputs_of_block = inputs_of_batch;
            if (!(block.grid == batch->block))
                stages->select(block.grid, scan::layout_of(block.grid, any.band, sign), inputs_of_block);
            auto of_block = make_plan(std::move(inputs_of_block), block.grid, any.band, outputs, wanted, call,
                                      compiling, made.pool);
            transform::add_slab(made.statistics, of_block->statistics);
            made.add(block, std::move(of_block), targets, programs);
        }
        return true;
    };
    make_room_for([&] { return device::guarded(make); });
    device::guarded([&] { context.queue().finish(); });  // errors of the set-up's commands are thrown here
    if (made.has_own_pool) made.pool->release();
    made.is_whole = true;
    made.statistics.polyhedra_seconds = polyhedra_seconds;
    made.statistics.device_bytes = made.own_bytes() + bytes_of_inputs;
    report(compiling, made.statistics);
    if (call.statistics != nullptr) *call.statistics = made.statistics;
}

Plan::Plan(std::unique_ptr<transform::RequestPlanState> state) : state_(std::move(state)) {}
Plan::Plan(Plan&&) noexcept = default;
Plan& Plan::operator=(Plan&&) noexcept = default;
Plan::~Plan() = default;

transform::RequestPlanState& Plan::state() const {
    return held_by(state_, "Plan");
}

const Grid& Plan::grid() const {
    return state().requests.front().grid;
}
const Band& Plan::band() const {
    return state().requests.front().band;
}
SignRule Plan::sign() const {
    return state().sign;
}
const TransformStatistics& Plan::statistics() const {
    return state().statistics;
}

cl_event Plan::enqueue(cl_command_queue queue, const OutputTargets& targets, std::span<const cl_event> wait_list) {
    transform::RequestPlanState& state = this->state();
    return device::guarded([&] {
        const scan::OutputBuffers in_place = state.set_targets(targets);
        return transform::enqueue_run(state, queue, wait_list, &in_place);
    });
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
    return device::guarded([&] { return transform::enqueue_run(state, queue, wait_list, nullptr); });
}

void RequestPlan::move(const DistanceTransform& transform, std::span<const Grid> grids, const CallOptions& call) {
    transform::RequestPlanState& state = this->state();
    if (!grids.empty() && grids.size() != state.requests.size())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the plan has {} requests, and {} grids are given to move them to; give one for each, "
                                "or none",
                                state.requests.size(), grids.size()));
    std::vector<Request> requests = state.requests;
    for (std::size_t n = 0; n < grids.size(); ++n) requests[n].grid = grids[n];
    transform.state().plan(state, std::move(requests), call);
}

Plan DistanceTransform::plan(const Grid& grid, const Band& band, const Outputs& outputs,
                             const CallOptions& call) const {
    State& state = this->state();
    grid.validate();
    band.validate();
    state.stages->check(grid, band, state.sign);
    auto made = std::make_unique<transform::RequestPlanState>(state.device, std::vector<Request>{{grid, band, {}}},
                                                              state.pool, false);
    const scan::DeviceTargets targets(outputs, grid);
    state.plan(*made, {&targets, 1}, call);
    return Plan(std::move(made));
}

Plan DistanceTransform::plan(const Request& request, const CallOptions& call) const {
    State& state = this->state();
    request.grid.validate();
    request.band.validate();
    state.stages->check(request.grid, request.band, state.sign);
    const scan::DeviceTargets targets = device::guarded(
        [&] { return scan::DeviceTargets(request.targets, request.grid, device::context_of(state.device)); });
    auto made =
        std::make_unique<transform::RequestPlanState>(state.device, std::vector<Request>{request}, state.pool, false);
    state.plan(*made, {&targets, 1}, call);
    return Plan(std::move(made));
}

RequestPlan DistanceTransform::plan(std::span<const Request> requests, const CallOptions& call) const {
    State& state = this->state();
    auto made =
        std::make_unique<transform::RequestPlanState>(state.device, std::vector<Request>(), state.pool->beside(), true);
    state.plan(*made, std::vector<Request>(requests.begin(), requests.end()), call);
    return RequestPlan(std::move(made));
}

std::size_t DistanceTransform::plan_bytes(std::span<const Request> requests, const CallOptions& call) const {
    return plan(requests, call).statistics().device_bytes;
}

}  // namespace clsdf

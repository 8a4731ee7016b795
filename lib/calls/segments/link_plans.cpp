#include "calls/transform/planning.hpp"
#include "checks/known_targets.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"

#include <clsdf/error.hpp>

#include <memory>
#include <utility>

namespace clsdf {

void DistanceTransform::State::plan(plans::LinkPlanState& plan, const plans::AskedLinks& asked, FoundLinks found,
                                    const CallOptions& call) {
    plan.require_device(device);
    make(plan, asked, call, [&](calls::RunningCall& running) {
        test(checks::stored_links_subject(device, programs), running);
        plans::PlannedLinks made;
        make_and_wait(running, [&] {
            // Called again if memory is short: planned() takes the links when it has the rest.
            made = found.on_device ? plans::planned(context(), pool, std::move(*found.on_device))
                                   : plans::uploaded(context(), pool, found.on_host, asked.room);
        });
        CallStatistics& statistics = running.statistics;
        static_cast<TransformStatistics&>(statistics) = found.statistics;
        statistics.triangles = kept_mesh->face_count();
        statistics.device_bytes = made.device_bytes();
        plan.replace(std::move(made));
        return statistics;
    });
}

LinkPlan::LinkPlan(std::unique_ptr<State> state) : state_(std::move(state)) {}
LinkPlan::LinkPlan(LinkPlan&&) noexcept = default;
LinkPlan& LinkPlan::operator=(LinkPlan&&) noexcept = default;
LinkPlan::~LinkPlan() = default;

LinkPlan::State& LinkPlan::state() const {
    return held_by(state_, "LinkPlan");
}

const Grid& LinkPlan::grid() const {
    return state().asked().grid;
}

std::span<const LinkDirection> LinkPlan::directions() const {
    return state().asked().directions;
}

const LinkOptions& LinkPlan::options() const {
    return state().asked().options;
}

std::size_t LinkPlan::room() const {
    return state().asked().room;
}

SignRule LinkPlan::sign() const {
    return state().sign;
}

const TransformStatistics& LinkPlan::statistics() const {
    return state().published;
}

void LinkPlan::enqueue(cl_command_queue queue, const LinkTargets& targets, const DeviceRange& count,
                       std::span<const cl_event> wait_list, cl_event* done) {
    State& state = this->state();
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] { state.enqueue({queue, wait_list, done}, targets, count); });
    });
}

void LinkPlan::update(const DistanceTransform& transform, const CallOptions& call) {
    update(transform, Grid(grid()), room(), call);
}

void LinkPlan::update(const DistanceTransform& transform, const Grid& grid, std::size_t room, const CallOptions& call) {
    with_host_memory("for the plan; plan a part of the grid", [&] {
        State& own = state();
        own.require_device(transform.device());
        plans::AskedLinks asked = own.asked();
        asked.grid = grid;
        asked.room = room;
        auto found = transform.state().find_planned_links(asked, call);
        transform.state().plan(own, asked, std::move(found), call);
    });
}

LinkPlan DistanceTransform::plan_links(const Grid& grid, std::span<const LinkDirection> directions, std::size_t room,
                                       const LinkOptions& options, const CallOptions& call) const {
    return with_host_memory("for the plan; plan a part of the grid", [&] {
        State& self = state();
        auto made = std::make_unique<LinkPlan::State>(self.device, self.pool, self.programs);
        const plans::AskedLinks asked{grid, {directions.begin(), directions.end()}, options, room};
        self.plan(*made, asked, self.find_planned_links(asked, call), call);
        return LinkPlan(std::move(made));
    });
}

}  // namespace clsdf

#include "plans/planned.hpp"

#include "core/refuse.hpp"
#include "targets/mapped_memory.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

namespace clsdf::plans {

void PlanBase::require_device(const Device& other) const {
    if (&device::context_of(other) != &context())
        refuse("the transform has another device than the plan; update the plan with a transform of its Device");
}

void PlanBase::require_whole() const {
    if (!is_whole_) refuse("the plan's last update failed, so that it has nothing to compute with; update it again");
}

void PlanBase::wait() {
    device::guarded([&] {
        if (const cl_int code = runs_.wait(); code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
    });
}

void PlanBase::run(const RunOptions& options, const std::function<void(engine::CommandChain&)>& enqueue) {
    device::Context& context = this->context();
    const cl::CommandQueue queue = targets::queue_of(context, options.queue);
    std::vector<cl::Event> before = targets::events_of(context, options.wait_list);
    context.require_usable();
    context.require_none_failed(failures);
    if (queue() == context.queue()() && !before.empty()) context.add_waiting_run();
    engine::CommandChain& chain = runs_.begin(queue, std::move(before));
    enqueue(chain);
    if (!chain.has_begun())
        chain.then([](const auto& to, auto* wait, auto* event) { to.enqueueMarkerWithWaitList(wait, event); });
    queue.flush();
    if (options.done == nullptr) return;
    clRetainEvent(chain.last()());
    *options.done = chain.last()();
}

void require_target(const OutputInfo& row, bool is_planned, bool has_target) {
    if (has_target == is_planned) return;
    throw Error(ErrorCode::invalid_argument,
                is_planned ? fmt::format("the plan computes the output {0}, and {0} has no target; give it memory, or "
                                         "plan without",
                                         row.name)
                           : fmt::format("the output {0} has a target, and the plan was made without; leave the "
                                         "target out, or make the plan with {0}",
                                         row.name));
}

}  // namespace clsdf::plans

#pragma once

#include "calls/transform/transform_state.hpp"

#include <functional>
#include <mutex>
#include <utility>

/// The way of every plan from a transform to its device. It is in calls, because it takes the transform's mutex, budget
/// and tests.
namespace clsdf {

/// Makes a plan, or makes it anew, for what is asked for. make_parts(running): gives the plan what its runs use, and
/// returns what that took.
template <class Plan, class Asked, class MakeParts>
void DistanceTransform::State::make(Plan& plan, Asked asked, const CallOptions& call, const MakeParts& make_parts) {
    mutex.check_thread();
    // It waits for the plan's runs before the mutex is locked: other threads may use the transform.
    plan.update(std::move(asked), [&] {
        const KeepsBudget keeps_budget(*this);
        const std::scoped_lock lock(mutex);
        calls::RunningCall running{call};
        running.throw_if_stopped();
        context().begin_call();
        plan.published = make_parts(running).published();
        plan.failures = failures;
        plan.sign = sign;
    });
}

/// Makes what a plan takes from the device's memory, and waits for it: runs on other queues read it. enqueue(): may be
/// called again with less memory, when all commands of the call before have ended.
inline void DistanceTransform::State::make_and_wait(calls::RunningCall& running, const std::function<void()>& enqueue) {
    calls::with_remedies(&running, {forgetting()}, [&] { context().run_or_drain(enqueue); });
    device::guarded([&] { context().finish(); });
}

}  // namespace clsdf

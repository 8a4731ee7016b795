#pragma once

#include "device/context.hpp"

#include <optional>
#include <vector>

namespace clsdf::transform {

/// On a processor, commands that are enqueued while it lives start together when it ends; nothing may be waited for
/// meanwhile. (PoCL's threads start with the first command, and take the core that would enqueue the others. Measured
/// on two cores: up to 60 us for each of them.)
class HeldBack {
public:
    explicit HeldBack(const device::Context& context) {
        if (!context.capabilities().is_processor) return;
        gate_.emplace(context.context());
        const std::vector<cl::Event> gate{*gate_};
        context.queue().enqueueBarrierWithWaitList(&gate);
    }
    HeldBack(const HeldBack&) = delete;
    HeldBack& operator=(const HeldBack&) = delete;
    ~HeldBack() {
        if (gate_) clSetUserEventStatus((*gate_)(), CL_COMPLETE);
    }

private:
    std::optional<cl::UserEvent> gate_;
};

}  // namespace clsdf::transform

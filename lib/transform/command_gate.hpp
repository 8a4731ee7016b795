#pragma once

#include "device/context.hpp"

#include <optional>
#include <utility>
#include <vector>

namespace clsdf::transform {

/// On a processor, commands that are enqueued until it is opened start together then. Nothing but enqueuing may be
/// done meanwhile: what waited for the queue would wait for ever. (PoCL's threads start with the first command, and
/// take the core that would enqueue the others. Measured on two cores: up to 60 us for each of them.)
class CommandGate {
public:
    explicit CommandGate(const device::Context& context) : context_(context) {
        if (!context.capabilities().is_processor) return;
        gate_.emplace(context.context());
        const std::vector<cl::Event> gate{*gate_};
        context.queue().enqueueBarrierWithWaitList(&gate);
    }
    CommandGate(const CommandGate&) = delete;
    CommandGate& operator=(const CommandGate&) = delete;
    ~CommandGate() {
        try {
            open();
        } catch (const cl::Error&) {
            // On the way out after another error.
        }
    }

    /// The commands start. Throws cl::Error.
    void open() {
        if (!gate_) return;
        const cl::UserEvent gate = *std::exchange(gate_, std::nullopt);
        const cl_int code = clSetUserEventStatus(gate(), CL_COMPLETE);
        if (code == CL_SUCCESS) return;
        // Again, or all that waits for the queue would wait for ever.
        if (clSetUserEventStatus(gate(), CL_COMPLETE) != CL_SUCCESS) context_.give_up();
        throw cl::Error(code, "clSetUserEventStatus");
    }

private:
    const device::Context& context_;
    std::optional<cl::UserEvent> gate_;
};

}  // namespace clsdf::transform

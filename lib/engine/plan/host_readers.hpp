#pragma once

#include "device/context.hpp"

namespace clsdf::transform {

/// The commands of the context's queue that read arrays of the host in place, as they do on a processor.
class HostReaders {
public:
    explicit HostReaders(const device::Context& context) : context_(context) {}

    /// While it lives, commands that are enqueued may be readers.
    class Mark {
    public:
        explicit Mark(HostReaders& readers) : readers_(readers) {}
        Mark(const Mark&) = delete;
        Mark& operator=(const Mark&) = delete;
        ~Mark() {
            const device::Context& context = readers_.context_;
            if (!context.capabilities().is_processor) return;
            cl_event end = nullptr;
            if (clEnqueueMarkerWithWaitList(context.queue()(), 0, nullptr, &end) != CL_SUCCESS) context.drain();
            readers_.last_ = cl::Event(end);
        }

    private:
        HostReaders& readers_;
    };

    /// Waits until they have ended, not for the commands after them, which may wait for the caller's events. False if
    /// the driver cannot tell that they have ended.
    bool wait() const noexcept {
        if (context_.is_lost()) return false;
        return device::has_ended(last_) || clWaitForEvents(1, &last_()) == CL_SUCCESS || context_.drain();
    }

private:
    const device::Context& context_;
    cl::Event last_;
};

}  // namespace clsdf::transform

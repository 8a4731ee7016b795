#pragma once

#include "device/opencl.hpp"

#include <utility>
#include <vector>

namespace clsdf::transform {

/// Commands of which each waits for the one before: the caller's queue may be out of order.
class CommandChain {
public:
    CommandChain(cl::CommandQueue queue, std::vector<cl::Event> wait_list)
        : queue_(std::move(queue)), previous_(std::move(wait_list)) {}

    /// enqueue_command(queue, wait list or null, event)
    template <class Enqueue>
    void then(Enqueue&& enqueue_command) {
        cl::Event event;
        enqueue_command(queue_, previous_.empty() ? nullptr : &previous_, &event);
        previous_.assign(1, event);
        has_begun_ = true;
    }

    void then_fill(const cl::Buffer& buffer, std::size_t bytes) {
        if (bytes == 0) return;
        then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueFillBuffer(buffer, cl_uchar{0}, 0, bytes, wait, event);
        });
    }

    /// Blocks until all commands so far have ended.
    void wait() const {
        if (!previous_.empty()) cl::Event::waitForEvents(previous_);
    }

    /// Whether there is a command, so that there is a last one.
    bool has_begun() const { return has_begun_; }
    const cl::Event& last() const { return previous_.front(); }
    const cl::CommandQueue& queue() const { return queue_; }

private:
    cl::CommandQueue queue_;
    std::vector<cl::Event> previous_;
    bool has_begun_ = false;
};

}  // namespace clsdf::transform

#pragma once

#include "device/context.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace clsdf::engine {

/// Sets a kernel's arguments from number `first` on, in the order of its parameters. Each must have the parameter's
/// type exactly, such as cl_uint: a number of another type has other bytes.
/// Returns the number of the next one.
template <class... Arguments>
cl_uint set_arguments(cl::Kernel& kernel, cl_uint first, const Arguments&... arguments) {
    (kernel.setArg(first++, arguments), ...);
    return first;
}

/// Work-items of a group, unless a kernel asks for another number. It is the same for all grids, because PoCL compiles
/// a kernel anew for each size.
constexpr std::size_t common_group = 64;

/// The number of work-items, rounded up to whole groups.
constexpr std::size_t in_whole_groups(std::size_t items, std::size_t group = common_group) {
    return (items + group - 1) / group * group;
}

/// The work-items of a launch, which are rounded up to whole groups.
struct WorkItems {
    std::size_t count;
    std::size_t group = common_group;

    cl::NDRange all() const { return cl::NDRange(in_whole_groups(count, group)); }
    cl::NDRange of_group() const { return cl::NDRange(group); }
};

/// Enqueues a kernel with these arguments, or with those that it has if none are given.
template <class... Arguments>
void launch(const cl::CommandQueue& queue, device::LentKernel& kernel, const WorkItems& items,
            const Arguments&... arguments) {
    set_arguments(kernel, 0, arguments...);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, items.all(), items.of_group());
    kernel.note_launch();
}

/// Commands of which each waits for the one before: the caller's queue may be out of order.
class CommandChain {
public:
    CommandChain(cl::CommandQueue queue, std::vector<cl::Event> wait_list)
        : queue_(std::move(queue)), awaited_(std::move(wait_list)), previous_(awaited_) {
        previous_.reserve(1);
    }

    /// enqueue_command(queue, wait list or null, event)
    template <class Enqueue>
    void then(Enqueue&& enqueue_command) {
        events_.emplace_back();  // first: a command that is enqueued must be known
        try {
            enqueue_command(queue_, previous_.empty() ? nullptr : &previous_, &events_.back());
        } catch (...) {
            events_.pop_back();
            throw;
        }
        previous_.assign(1, events_.back());
    }

    void then_launch(const device::LentKernel& kernel, const WorkItems& items) {
        then_launch(kernel, cl::NullRange, items.all(), items.of_group());
    }
    void then_launch(const device::LentKernel& kernel, const cl::NDRange& offset, const cl::NDRange& items,
                     const cl::NDRange& group) {
        then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueNDRangeKernel(kernel, offset, items, group, wait, event);
        });
        kernel.note_launch();
    }

    void then_fill(const cl::Buffer& buffer, std::size_t bytes) {
        if (bytes == 0) return;
        then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueFillBuffer(buffer, cl_uchar{0}, 0, bytes, wait, event);
        });
    }

    /// Whether there is a command, so that there is a last one.
    bool has_begun() const { return !events_.empty(); }
    const cl::Event& last() const { return events_.back(); }
    /// The events of all commands so far.
    const std::vector<cl::Event>& events() const { return events_; }
    /// The wait list.
    const std::vector<cl::Event>& awaited() const { return awaited_; }
    const cl::CommandQueue& queue() const { return queue_; }

private:
    cl::CommandQueue queue_;
    std::vector<cl::Event> awaited_;
    std::vector<cl::Event> previous_;
    std::vector<cl::Event> events_;
};

}  // namespace clsdf::engine

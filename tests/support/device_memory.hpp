#pragma once

#include "device/context.hpp"
#include "device/opencl.hpp"

#include <clsdf/plan.hpp>

#include <cstdint>
#include <span>
#include <vector>

/// Memory of a device, as a caller has it.
namespace clsdf::test {

/// The first `count` values of a buffer.
template <class Value>
std::vector<Value> read(const device::Context& context, const cl::Buffer& buffer, std::size_t count) {
    std::vector<Value> values(count);
    if (count > 0) context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(Value), values.data());
    return values;
}

/// Values that nothing computes.
inline constexpr std::uint32_t untouched = 0xABABABABU;

class DeviceMemory {
public:
    DeviceMemory(cl_context context, std::size_t count)
        : count_(count),
          buffer_(cl::Context(context, true), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, count * sizeof(cl_uint),
                  std::vector<std::uint32_t>(count, untouched).data()) {}

    cl_mem handle() const { return buffer_(); }

    /// The very bits; blocks.
    std::vector<std::uint32_t> read(const cl::CommandQueue& queue) const {
        std::vector<std::uint32_t> bits(count_);
        queue.enqueueReadBuffer(buffer_, CL_TRUE, 0, count_ * sizeof(cl_uint), bits.data());
        return bits;
    }

private:
    std::size_t count_;
    cl::Buffer buffer_;
};

/// Enqueues a run of a plan, and returns the event of its end.
inline cl::Event enqueue(Plan& plan, cl_command_queue queue, std::span<const cl_event> wait_list = {}) {
    cl_event done = nullptr;
    plan.enqueue(queue, wait_list, &done);
    return cl::Event(done);
}
inline cl::Event enqueue(Plan& plan, cl_command_queue queue, const OutputTargets& targets,
                         std::span<const cl_event> wait_list = {}) {
    cl_event done = nullptr;
    plan.enqueue(queue, targets, wait_list, &done);
    return cl::Event(done);
}
inline cl::Event enqueue(Plan& plan, cl_command_queue queue, std::span<const OutputTargets> targets,
                         std::span<const cl_event> wait_list = {}) {
    cl_event done = nullptr;
    plan.enqueue(queue, targets, wait_list, &done);
    return cl::Event(done);
}

}  // namespace clsdf::test

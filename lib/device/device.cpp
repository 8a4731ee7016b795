#include <clsdf/device.hpp>

#include "core/moved_from.hpp"
#include "device/context.hpp"

namespace clsdf {

Device Device::open(const DeviceInfo& info) {
    const cl::Device device(info.id, true);
    const cl::Context context(device);
    return Device(std::make_shared<device::Context>(context, device, cl::CommandQueue(context, device)));
}

Device Device::from_handles(cl_context context, cl_device_id id, cl_command_queue queue) {
    if (context == nullptr || id == nullptr || queue == nullptr)
        throw Error(ErrorCode::invalid_argument,
                    "Device::from_handles needs a context, a device and a queue; one of them is null");
    return device::guarded([&] {
        const cl::CommandQueue callers(queue, true);
        if (callers.getInfo<CL_QUEUE_CONTEXT>()() != context || callers.getInfo<CL_QUEUE_DEVICE>()() != id)
            throw Error(ErrorCode::invalid_argument,
                        "Device::from_handles: the queue belongs to another context or device than those given");
        return Device(std::make_shared<device::Context>(cl::Context(context, true), cl::Device(id, true), callers));
    });
}

device::Context& Device::internal() const {
    return held_by(context_, "Device");
}

const std::shared_ptr<device::Context>& Device::shared() const {
    internal();
    return context_;
}

std::string Device::name() const {
    return device::guarded([&] { return internal().device().getInfo<CL_DEVICE_NAME>(); });
}

std::string Device::platform() const {
    return device::guarded(
        [&] { return cl::Platform(internal().device().getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>(); });
}

std::string Device::program_cache() const {
    return internal().cache_folder().string();
}

std::string Device::record_folder() const {
    return context_->records().folder().string();
}

void Device::set_program_cache(const std::string& folder) const {
    internal().set_cache_folder(folder);
}

void Device::forget_tests() const {
    context_->records().forget(context_->identity());
    context_->forget_tests();
}

cl_context Device::context() const {
    return internal().context()();
}
cl_device_id Device::id() const {
    return internal().device()();
}
cl_command_queue Device::queue() const {
    return internal().callers_queue()();
}

}  // namespace clsdf

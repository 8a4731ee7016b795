#include <clsdf/device.hpp>

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

std::string Device::name() const {
    return device::guarded([&] { return context_->device().getInfo<CL_DEVICE_NAME>(); });
}

std::string Device::platform() const {
    return device::guarded(
        [&] { return cl::Platform(context_->device().getInfo<CL_DEVICE_PLATFORM>()).getInfo<CL_PLATFORM_NAME>(); });
}

std::string Device::program_cache() const {
    return context_->cache_folder().string();
}

std::string Device::record_folder() const {
    return context_->records().folder().string();
}

void Device::set_program_cache(const std::string& folder) const {
    context_->set_cache_folder(folder);
}

void Device::forget_tests() const {
    context_->records().forget(context_->identity());
    context_->forget_tests();
}

cl_context Device::context() const {
    return context_->context()();
}
cl_device_id Device::id() const {
    return context_->device()();
}
cl_command_queue Device::queue() const {
    return context_->callers_queue()();
}

}  // namespace clsdf

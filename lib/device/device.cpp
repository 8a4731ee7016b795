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

const std::shared_ptr<device::Context>& device::shared_context_of(const Device& device) {
    held_by(device.context_, "Device");
    return device.context_;
}

device::Context& device::context_of(const Device& device) {
    return *shared_context_of(device);
}

std::string Device::name() const {
    return device::guarded([&] { return device::context_of(*this).device().getInfo<CL_DEVICE_NAME>(); });
}

std::string Device::platform() const {
    return device::guarded([&] {
        return cl::Platform(device::context_of(*this).device().getInfo<CL_DEVICE_PLATFORM>())
            .getInfo<CL_PLATFORM_NAME>();
    });
}

std::string Device::program_cache() const {
    return device::context_of(*this).cache_folder().string();
}

std::string Device::record_folder() const {
    return device::context_of(*this).records().folder().string();
}

void Device::set_program_cache(const std::string& folder) const {
    device::context_of(*this).set_cache_folder(folder);
}

void Device::forget_tests() const {
    device::Context& context = device::context_of(*this);
    context.records().forget(context.identity());
    context.forget_tests();
}

cl_context Device::context() const {
    return device::context_of(*this).context()();
}
cl_device_id Device::id() const {
    return device::context_of(*this).device()();
}
cl_command_queue Device::queue() const {
    return device::context_of(*this).callers_queue()();
}

}  // namespace clsdf

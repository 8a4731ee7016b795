#include <clsdf/device.hpp>

#include "device/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

constexpr const char* how_to_install =
    "install an OpenCL driver: for any processor PoCL (Debian: apt install pocl-opencl-icd); for a GPU its maker's, "
    "nvidia-opencl-icd (NVIDIA), mesa-opencl-icd or ROCm (AMD), intel-opencl-icd (Intel)";

std::vector<cl::Device> all_devices() {
    std::vector<cl::Platform> platforms;
    std::vector<cl::Device> devices;
    try {
        cl::Platform::get(&platforms);
    } catch (const cl::Error&) {
        return devices;  // the loader reports "no platform" as an error
    }
    for (const cl::Platform& platform : platforms) {
        std::vector<cl::Device> found;
        try {
            platform.getDevices(CL_DEVICE_TYPE_ALL, &found);
        } catch (const cl::Error&) {
            continue;  // a platform without devices
        }
        devices.insert(devices.end(), found.begin(), found.end());
    }
    return devices;
}

/// GPUs before everything else, then by compute units times clock, a stand-in for speed.
double strength(const cl::Device& device) {
    const bool gpu = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
    const double rate = static_cast<double>(device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>()) *
                        static_cast<double>(device.getInfo<CL_DEVICE_MAX_CLOCK_FREQUENCY>());
    return (gpu ? 1e12 : 0.0) + rate;
}

bool is_usable(const cl::Device& device) {
    return device.getInfo<CL_DEVICE_AVAILABLE>() != 0 && device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>() != 0 &&
           device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0;
}

/// Usable devices, the strongest first. One that fails when it is asked is left out.
std::vector<cl::Device> candidates(const std::vector<cl::Device>& devices) {
    std::vector<std::pair<double, cl::Device>> rated;
    for (const cl::Device& device : devices) {
        try {
            if (is_usable(device)) rated.emplace_back(strength(device), device);
        } catch (const cl::Error&) {
            continue;
        }
    }
    std::stable_sort(rated.begin(), rated.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<cl::Device> sorted;
    for (const auto& [rate, device] : rated) sorted.push_back(device);
    return sorted;
}

}  // namespace

Device Device::best() {
    const std::vector<cl::Device> devices = all_devices();
    std::string failures;
    for (const cl::Device& device : candidates(devices)) {
        try {
            const cl::Context context(device);
            return Device(std::make_shared<device::Context>(context, device, cl::CommandQueue(context, device)));
        } catch (const cl::Error& error) {
            failures += fmt::format("; \"{}\" failed at {}: {}", device.getInfo<CL_DEVICE_NAME>(), error.what(),
                                    device::code_name(error.err()));
        }
    }
    throw Error(ErrorCode::no_device,
                fmt::format("{}{}; {}",
                            devices.empty() ? "no OpenCL device was found"
                                            : "no usable OpenCL device with double precision and a compiler was found",
                            failures, how_to_install));
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

#include "cuda/lanes.hpp"

#include "device/opencl.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>

namespace clsdf::cuda {

namespace {

using Uuid = std::array<unsigned char, 16>;

// Constants of OpenCL's extensions.
constexpr cl_device_info device_uuid = 0x106A;        // CL_DEVICE_UUID_KHR
constexpr cl_device_info export_semaphores = 0x204E;  // CL_DEVICE_SEMAPHORE_EXPORT_HANDLE_TYPES_KHR
constexpr cl_uint opaque_semaphore = 0x2055;          // CL_SEMAPHORE_HANDLE_OPAQUE_FD_KHR
constexpr unsigned without_timing = 2;                // CU_EVENT_DISABLE_TIMING

std::string text_of(const Uuid& uuid) {
    std::string text;
    for (const unsigned char byte : uuid) {
        std::array<char, 3> digits{};
        std::snprintf(digits.data(), digits.size(), "%02x", byte);
        text += digits.data();
        if (text.size() == 8 || text.size() == 13 || text.size() == 18 || text.size() == 23) text += '-';
    }
    return text;
}

std::string extensions_of(cl_device_id device) {
    std::size_t bytes = 0;
    check_cl(clGetDeviceInfo(device, CL_DEVICE_EXTENSIONS, 0, nullptr, &bytes), "clGetDeviceInfo");
    std::string names(bytes, '\0');
    check_cl(clGetDeviceInfo(device, CL_DEVICE_EXTENSIONS, bytes, names.data(), nullptr), "clGetDeviceInfo");
    return ' ' + names.substr(0, names.find('\0')) + ' ';
}

bool has(const std::string& extensions, const char* name) {
    return extensions.find(std::string(" ") + name + ' ') != std::string::npos;
}

Uuid uuid_of(const Device& device) {
    const std::string extensions = extensions_of(device.id());
    for (const char* name : {"cl_khr_device_uuid", "cl_khr_external_memory_opaque_fd"})
        if (!has(extensions, name))
            throw Error(ErrorCode::unsupported,
                        "the device \"" + device.name() + "\" has no " + name +
                            ", so it shares no memory with CUDA; pass a copy of the array in the host's memory, or "
                            "choose an NVIDIA GPU (`clsdf devices` lists what there is)");
    Uuid uuid{};
    check_cl(clGetDeviceInfo(device.id(), device_uuid, uuid.size(), uuid.data(), nullptr), "clGetDeviceInfo");
    return uuid;
}

/// The number that CUDA has for the device.
int ordinal_of(const Device& device) {
    const Uuid wanted = uuid_of(device);
    int count = 0;
    check(driver().device_count(&count), "cuDeviceGetCount");
    std::string found;
    for (int ordinal = 0; ordinal < count; ++ordinal) {
        int handle = 0;
        Uuid uuid{};
        check(driver().device(&handle, ordinal), "cuDeviceGet");
        check(driver().uuid(uuid.data(), handle), "cuDeviceGetUuid");
        if (uuid == wanted) return ordinal;
        found += (found.empty() ? "" : ", ") + text_of(uuid);
    }
    throw Error(ErrorCode::no_device,
                "CUDA does not list the device \"" + device.name() + "\" with the UUID " + text_of(wanted) +
                    "; its devices have " + found +
                    ". CUDA_VISIBLE_DEVICES hides devices from CUDA; or choose another device for "
                    "clsdf");
}

template <typename Function>
void find(cl_platform_id platform, const char* name, Function& function) {
    function = reinterpret_cast<Function>(clGetExtensionFunctionAddressForPlatform(platform, name));
}

Extensions extensions_for(const Device& device) {
    cl_platform_id platform = nullptr;
    check_cl(clGetDeviceInfo(device.id(), CL_DEVICE_PLATFORM, sizeof(cl_platform_id), &platform, nullptr),
             "clGetDeviceInfo");
    Extensions found;
    find(platform, "clEnqueueAcquireExternalMemObjectsKHR", found.acquire);
    find(platform, "clEnqueueReleaseExternalMemObjectsKHR", found.release);
    if (found.acquire == nullptr || found.release == nullptr)
        throw Error(ErrorCode::unsupported, "the driver of \"" + device.name() +
                                                "\" has no clEnqueueAcquireExternalMemObjectsKHR; update it, or pass a "
                                                "copy of the array in the host's memory");
    std::array<cl_uint, 16> types{};
    std::size_t bytes = 0;
    const std::string names = extensions_of(device.id());
    const bool is_exported =
        has(names, "cl_khr_semaphore") && has(names, "cl_khr_external_semaphore_opaque_fd") &&
        clGetDeviceInfo(device.id(), export_semaphores, sizeof types, types.data(), &bytes) == CL_SUCCESS &&
        std::find(types.begin(), types.end(), opaque_semaphore) != types.end();
    if (!is_exported) return found;
    find(platform, "clCreateSemaphoreWithPropertiesKHR", found.create);
    find(platform, "clReleaseSemaphoreKHR", found.destroy);
    find(platform, "clGetSemaphoreHandleForTypeKHR", found.handle);
    find(platform, "clEnqueueWaitSemaphoresKHR", found.wait);
    find(platform, "clEnqueueSignalSemaphoresKHR", found.signal);
    return found;
}

}  // namespace

void check_cl(cl_int code, const char* call) {
    if (code != CL_SUCCESS) device::throw_device_error(cl::Error(code, call));
}

Link::Link(const Device& device) : device_(device), ordinal_(ordinal_of(device)), extensions_(extensions_for(device)) {
    check(driver().device(&handle_, ordinal_), "cuDeviceGet");
    check(driver().retain_primary(&context_, handle_), "cuDevicePrimaryCtxRetain");
}

Link::~Link() {
    if (driver().push(context_) == 0) {
        for (std::unique_ptr<Lane>& lane : lanes_)
            if (lane->is_recorded) driver().finish_event(lane->latest);
        lanes_.clear();
        ContextHandle before = nullptr;
        driver().pop(&before);
    }
    driver().release_primary(handle_);
}

std::unique_ptr<Lane> Link::take_lane(std::size_t bytes) {
    const Current current(context_);
    std::unique_ptr<Lane> lane;
    {
        // The smallest that is large enough, else the largest.
        const std::scoped_lock lock(mutex_);
        const auto room = [](const std::unique_ptr<Lane>& one) {
            return one->staging == nullptr ? 0 : one->staging->bytes();
        };
        auto best = lanes_.end();
        for (auto one = lanes_.begin(); one != lanes_.end(); ++one) {
            if (best == lanes_.end() ||
                (room(*best) < bytes ? room(*one) > room(*best) : room(*one) >= bytes && room(*one) < room(*best)))
                best = one;
        }
        if (best != lanes_.end()) {
            lane = std::move(*best);
            lanes_.erase(best);
        }
    }
    if (lane == nullptr) lane = std::make_unique<Lane>(*this);
    if (bytes > 0 && (lane->staging == nullptr || lane->staging->bytes() < bytes)) {
        lane->staging.reset();
        lane->staging = std::make_unique<Allocation>(*this, bytes);
    }
    return lane;
}

void Link::give_back(std::unique_ptr<Lane> lane) noexcept {
    const std::scoped_lock lock(mutex_);
    lanes_.push_back(std::move(lane));
}

std::size_t Link::release_memory() {
    std::vector<std::unique_ptr<Allocation>> freed;
    {
        const std::scoped_lock lock(mutex_);
        for (std::unique_ptr<Lane>& lane : lanes_)
            if (lane->staging != nullptr) freed.push_back(std::move(lane->staging));
    }
    std::size_t bytes = 0;
    for (const std::unique_ptr<Allocation>& one : freed) bytes += one->bytes();
    return bytes;
}

SharedDevice::SharedDevice(const Device& device) : link_(std::make_shared<Link>(device)) {}

const Device& SharedDevice::device() const {
    return link_->device();
}

int SharedDevice::ordinal() const {
    return link_->ordinal();
}

bool SharedDevice::has_semaphores() const {
    return link_->has_semaphores();
}

std::size_t SharedDevice::release_memory() const {
    return link_->release_memory();
}

void SharedDevice::order(void* earlier, void* later) const {
    if (named(earlier) == named(later)) return;
    const Current current(link_->context());
    Event event = nullptr;
    check(driver().create_event(&event, without_timing), "cuEventCreate");
    const int recorded = driver().record_event(event, named(earlier));
    const int waited = recorded == 0 ? driver().wait_event(named(later), event, 0) : 0;
    driver().destroy_event(event);
    check(recorded, "cuEventRecord");
    check(waited, "cuStreamWaitEvent");
}

void SharedDevice::copy_to_host(const Array& array, void* to) const {
    const Current current(link_->context());
    check(driver().copy_down(to, array.address, array.bytes, named(array.stream)), "cuMemcpyDtoHAsync");
    check(driver().finish_stream(named(array.stream)), "cuStreamSynchronize");
}

void SharedDevice::copy_from_host(const void* from, const Array& array) const {
    const Current current(link_->context());
    check(driver().copy_up(array.address, from, array.bytes, named(array.stream)), "cuMemcpyHtoDAsync");
    check(driver().finish_stream(named(array.stream)), "cuStreamSynchronize");
}

}  // namespace clsdf::cuda

#include "cuda_memory.hpp"

#include "binding.hpp"

#include <clsdf/error.hpp>

#include <unistd.h>
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

namespace clsdf::python::cuda {

namespace {

using Uuid = std::array<unsigned char, 16>;

// Constants of OpenCL's extensions.
constexpr cl_device_info device_uuid = 0x106A;        // CL_DEVICE_UUID_KHR
constexpr cl_device_info export_semaphores = 0x204E;  // CL_DEVICE_SEMAPHORE_EXPORT_HANDLE_TYPES_KHR
constexpr cl_ulong semaphore_type = 0x203D;           // CL_SEMAPHORE_TYPE_KHR
constexpr cl_ulong binary = 1;                        // CL_SEMAPHORE_TYPE_BINARY_KHR
constexpr cl_ulong export_types = 0x203F;             // CL_SEMAPHORE_EXPORT_HANDLE_TYPES_KHR
constexpr cl_uint opaque_semaphore = 0x2055;          // CL_SEMAPHORE_HANDLE_OPAQUE_FD_KHR
// Constants of CUDA.
constexpr unsigned without_timing = 2;       // CU_EVENT_DISABLE_TIMING
constexpr unsigned non_blocking_stream = 1;  // CU_STREAM_NON_BLOCKING
constexpr int posix_descriptor = 1;          // CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR

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
                            "choose an NVIDIA GPU (clsdf.devices() lists what there is)");
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
    throw Error(ErrorCode::no_device, "CUDA does not list the device \"" + device.name() + "\" with the UUID " +
                                          text_of(wanted) + "; its devices have " + found +
                                          ". CUDA_VISIBLE_DEVICES hides devices from CUDA; device= chooses another one "
                                          "for clsdf");
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

std::size_t rounded(std::size_t bytes, std::size_t granularity) {
    return (std::max<std::size_t>(bytes, 1) + granularity - 1) / granularity * granularity;
}

}  // namespace

void ClEvent::wait() const {
    if (event_ != nullptr) check_cl(clWaitForEvents(1, &event_), "clWaitForEvents");
}

void check_cl(cl_int code, const char* call) {
    if (code != CL_SUCCESS)
        throw Error(ErrorCode::device_failure,
                    std::string("the OpenCL call ") + call + " failed: OpenCL error " + std::to_string(code), code);
}

Allocation::Allocation(Link& link, std::size_t bytes) : link_(link) {
    const Current current(link.context());
    const Driver& cuda = driver();
    AllocationProperties properties;
    properties.location.id = link.ordinal();
    std::size_t granularity = 0;
    check(cuda.granularity(&granularity, &properties, 0), "cuMemGetAllocationGranularity");
    bytes_ = rounded(bytes, granularity);
    Allocated handle = 0;
    int descriptor = -1;
    check(cuda.create(&handle, bytes_, &properties, 0), "cuMemCreate");
    try {
        check(cuda.reserve(&address_, bytes_, 0, 0, 0), "cuMemAddressReserve");
        check(cuda.map(address_, bytes_, 0, handle, 0), "cuMemMap");
        is_mapped_ = true;
        Access access;
        access.location.id = link.ordinal();
        check(cuda.set_access(address_, bytes_, &access, 1), "cuMemSetAccess");
        check(cuda.export_handle(&descriptor, handle, posix_descriptor, 0), "cuMemExportToShareableHandle");
        buffer_ = link.device().import_memory(descriptor, bytes_);
        descriptor = -1;                                                // the driver's
        check(cuda.release(std::exchange(handle, 0)), "cuMemRelease");  // the mapping keeps the memory
    } catch (...) {
        if (descriptor >= 0) ::close(descriptor);
        if (handle != 0) cuda.release(handle);
        free();
        throw;
    }
}

Allocation::~Allocation() {
    if (!is_process_of_devices()) return;
    try {
        const Current current(link_.context());
        driver().synchronize();
        free();
    } catch (const Error&) {  // the driver has ended with the process
    }
}

void Allocation::free() noexcept {
    if (buffer_ != nullptr) clReleaseMemObject(buffer_);
    if (is_mapped_) driver().unmap(address_, bytes_);
    if (address_ != 0) driver().unreserve(address_, bytes_);
}

SharedSemaphore::SharedSemaphore(const Link& own) : link(own) {
    const Extensions& extensions = link.extensions();
    const std::array<cl_ulong, 6> properties{semaphore_type, binary, export_types, opaque_semaphore, 0, 0};
    cl_int code = CL_SUCCESS;
    of_opencl = extensions.create(link.device().context(), properties.data(), &code);
    check_cl(code, "clCreateSemaphoreWithPropertiesKHR");
    SemaphoreDescription description;
    code = extensions.handle(of_opencl, link.device().id(), opaque_semaphore, sizeof(int), &description.descriptor,
                             nullptr);
    const Current current(link.context());
    const int imported = code == CL_SUCCESS ? driver().import_semaphore(&of_cuda, &description) : 0;
    if (code == CL_SUCCESS && imported == 0) return;
    if (code == CL_SUCCESS) ::close(description.descriptor);
    extensions.destroy(of_opencl);
    check_cl(code, "clGetSemaphoreHandleForTypeKHR");
    check(imported, "cuImportExternalSemaphore");
}

SharedSemaphore::~SharedSemaphore() {
    driver().destroy_semaphore(of_cuda);
    link.extensions().destroy(of_opencl);
}

Lane::Lane(Link& own) : link(own) {
    check(driver().create_event(&latest, without_timing), "cuEventCreate");
    if (const int code = driver().create_event(&crossing, without_timing)) {
        driver().destroy_event(latest);
        check(code, "cuEventCreate");
    }
}

Lane::~Lane() {
    semaphores.reset();
    driver().destroy_event(crossing);
    driver().destroy_event(latest);
}

Link::Link(const Device& device) : device_(device), ordinal_(ordinal_of(device)), extensions_(extensions_for(device)) {
    check(driver().device(&handle_, ordinal_), "cuDeviceGet");
    check(driver().retain_primary(&context_, handle_), "cuDevicePrimaryCtxRetain");
}

Link::~Link() {
    if (!is_process_of_devices()) {
        for (std::unique_ptr<Lane>& lane : lanes_) static_cast<void>(lane.release());
        return;
    }
    if (driver().push(context_) == 0) {
        for (std::unique_ptr<Lane>& lane : lanes_)
            if (lane->is_recorded) driver().finish_event(lane->latest);
        lanes_.clear();
        ContextHandle before = nullptr;
        driver().pop(&before);
    }
    driver().release_primary(handle_);
}

bool Link::has_semaphores() {
    std::call_once(is_tried_, [this] {
        const bool is_complete = extensions_.create != nullptr && extensions_.destroy != nullptr &&
                                 extensions_.handle != nullptr && extensions_.wait != nullptr &&
                                 extensions_.signal != nullptr;
        try {
            has_semaphores_ = is_complete && try_semaphores();
        } catch (const Error&) {  // a driver that cannot make them: calls wait instead
        }
    });
    return has_semaphores_;
}

// CUDA signals, OpenCL waits and signals, CUDA waits. A driver that has not done this in a second never does. The
// test's objects are left to it then, and each side signals itself, so that no later wait for the whole device waits
// for them.
bool Link::try_semaphores() {
    constexpr std::chrono::seconds limit{1};
    const Current current(context_);
    const Driver& cuda = driver();
    cl_int code = CL_SUCCESS;
    const cl_command_queue queue = clCreateCommandQueue(device_.context(), device_.id(), 0, &code);
    check_cl(code, "clCreateCommandQueue");
    Stream stream = nullptr;
    check(cuda.create_stream(&stream, non_blocking_stream), "cuStreamCreate");
    auto lane = std::make_unique<Lane>(*this);
    lane->semaphores = std::make_unique<Semaphores>(*this);
    const Semaphores& both = *lane->semaphores;
    const SemaphoreParameters parameters;
    const int failed = cuda.signal(&both.to_opencl.of_cuda, &parameters, 1, stream) != 0 ||
                       extensions_.wait(queue, 1, &both.to_opencl.of_opencl, nullptr, 0, nullptr, nullptr) != 0 ||
                       extensions_.signal(queue, 1, &both.to_cuda.of_opencl, nullptr, 0, nullptr, nullptr) != 0 ||
                       clFlush(queue) != 0 || cuda.wait(&both.to_cuda.of_cuda, &parameters, 1, stream) != 0 ||
                       cuda.record_event(lane->latest, stream) != 0;
    const auto begin = std::chrono::steady_clock::now();
    bool is_done = false;
    while (failed == 0 && !is_done && std::chrono::steady_clock::now() - begin < limit) {
        is_done = cuda.query_event(lane->latest) == 0;
        if (!is_done) std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    if (!is_done) {
        static_cast<void>(lane.release());
        Stream second_stream = nullptr;
        if (cuda.create_stream(&second_stream, non_blocking_stream) == 0)
            cuda.signal(&both.to_cuda.of_cuda, &parameters, 1, second_stream);
        const cl_command_queue second_queue = clCreateCommandQueue(device_.context(), device_.id(), 0, &code);
        if (code == CL_SUCCESS) {
            extensions_.signal(second_queue, 1, &both.to_opencl.of_opencl, nullptr, 0, nullptr, nullptr);
            clFlush(second_queue);
        }
        return false;
    }
    clReleaseCommandQueue(queue);
    cuda.destroy_stream(stream);
    give_back(std::move(lane));
    return true;
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

namespace {

struct Registry {
    std::mutex mutex;
    std::map<Pointer, std::weak_ptr<SharedMemory>> all;  ///< by the first address
};
Registry& registry() {
    static auto* const only = new Registry;
    return *only;
}

}  // namespace

std::shared_ptr<SharedMemory> new_shared_memory(std::shared_ptr<Link> link, std::size_t bytes) {
    // The address leaves the registry before the memory is freed, so that no other memory has it.
    std::shared_ptr<SharedMemory> memory(new SharedMemory(std::move(link), bytes), [](SharedMemory* own) {
        if (!is_process_of_devices()) return;
        {
            const std::scoped_lock lock(registry().mutex);
            registry().all.erase(own->allocation().address());
        }
        delete own;
    });
    const std::scoped_lock lock(registry().mutex);
    registry().all[memory->allocation().address()] = memory;
    return memory;
}

std::shared_ptr<SharedMemory> shared_memory_at(Pointer address) {
    std::shared_ptr<SharedMemory> memory;  // ends after the lock: it may be the last owner, whose end takes the mutex
    const std::scoped_lock lock(registry().mutex);
    auto after = registry().all.upper_bound(address);
    if (after == registry().all.begin()) return nullptr;
    memory = std::prev(after)->second.lock();
    if (memory == nullptr || address >= memory->allocation().address() + memory->allocation().bytes()) return nullptr;
    return memory;
}

}  // namespace clsdf::python::cuda

// Memory and semaphores that OpenCL shares with CUDA: cl_khr_external_memory_opaque_fd, cl_khr_semaphore and
// cl_khr_external_semaphore_opaque_fd. Their descriptors are those of the stand-in for CUDA's driver (cuda/driver.cpp):
// a memfd of the device's UUID, and an eventfd. A command that uses such memory without having acquired it is refused,
// and on real devices undefined.
#include "disguise/external.hpp"

#include "disguise/gpu.hpp"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstring>
#include <map>
#include <memory>
#include <string_view>
#include <thread>
#include <vector>

using Properties = cl_ulong;  // cl_mem_properties, cl_semaphore_properties_khr

/// A binary semaphore: the counter of the eventfd is 0 if it is not signalled. Its waits take turns, in the order in
/// which they were enqueued.
struct Payload {
    explicit Payload(int descriptor_in) : descriptor(descriptor_in) {}
    ~Payload() { ::close(descriptor); }
    Payload(const Payload&) = delete;
    Payload& operator=(const Payload&) = delete;

    const int descriptor;
    std::mutex mutex;
    std::condition_variable changed;
    std::uint64_t enqueued = 0, ended = 0;
};
struct Semaphore {
    cl_context context;
    std::shared_ptr<Payload> payload;
    std::atomic<int> owners{1};
};

extern "C" {
cl_mem clCreateBufferWithProperties(cl_context context, const Properties* properties, cl_mem_flags flags,
                                    std::size_t bytes, void* host, cl_int* error);
}

namespace clsdf::disguise {

namespace {

constexpr Properties opaque_memory = 0x2060;          // CL_EXTERNAL_MEMORY_HANDLE_OPAQUE_FD_KHR
constexpr Properties dma_buffer = 0x2067;             // CL_EXTERNAL_MEMORY_HANDLE_DMA_BUF_KHR
constexpr Properties semaphore_type = 0x203D;         // CL_SEMAPHORE_TYPE_KHR
constexpr Properties semaphore_export = 0x203F;       // CL_SEMAPHORE_EXPORT_HANDLE_TYPES_KHR
constexpr Properties opaque_semaphore = 0x2055;       // CL_SEMAPHORE_HANDLE_OPAQUE_FD_KHR
constexpr Properties binary = 1;                      // CL_SEMAPHORE_TYPE_BINARY_KHR
constexpr cl_int invalid_semaphore = -1142;           // CL_INVALID_SEMAPHORE_KHR
constexpr cl_device_info import_memory = 0x204F;      // CL_DEVICE_EXTERNAL_MEMORY_IMPORT_HANDLE_TYPES_KHR
constexpr cl_device_info export_semaphores = 0x204E;  // CL_DEVICE_SEMAPHORE_EXPORT_HANDLE_TYPES_KHR
constexpr cl_device_info device_uuid = 0x106A;        // CL_DEVICE_UUID_KHR

/// Memory that was imported: the driver owns the descriptor.
struct External {
    int descriptor;
    void* address;
    std::size_t bytes;
    bool is_acquired = false;
};

struct Externals {
    std::mutex mutex;
    std::map<cl_mem, External> all;
};
Externals& externals() {
    static auto* const only = new Externals;
    return *only;
}

std::string target_of(int descriptor) {
    std::array<char, 256> name{};
    const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
    const ssize_t length = ::readlink(link.c_str(), name.data(), name.size() - 1);
    return length < 0 ? std::string() : std::string(name.data(), static_cast<std::size_t>(length));
}

void CL_CALLBACK forget(cl_mem buffer, void*) {
    External external{};
    {
        const std::scoped_lock lock(externals().mutex);
        const auto found = externals().all.find(buffer);
        external = found->second;
        externals().all.erase(found);
    }
    ::munmap(external.address, external.bytes);
    ::close(external.descriptor);
}

cl_mem import(cl_context context, int descriptor, std::size_t bytes, cl_int* error) {
    struct stat status {};
    const std::string target = target_of(descriptor);
    if (target.find("memfd:cuda-") == std::string::npos || ::fstat(descriptor, &status) != 0)
        return refused(CL_INVALID_VALUE, error);
    if (target.find(std::string("memfd:cuda-") + uuid) == std::string::npos) return refused(CL_INVALID_DEVICE, error);
    if (bytes > static_cast<std::size_t>(status.st_size)) return refused(CL_INVALID_BUFFER_SIZE, error);
    void* const address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (address == MAP_FAILED) return refused(CL_OUT_OF_HOST_MEMORY, error);
    const cl_mem buffer =
        CLSDF_NEXT(clCreateBuffer)(context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, address, error);
    if (buffer == nullptr) {
        ::munmap(address, bytes);
        return nullptr;
    }
    {
        const std::scoped_lock lock(externals().mutex);
        externals().all[buffer] = {descriptor, address, bytes};
    }
    CLSDF_NEXT(clSetMemObjectDestructorCallback)(buffer, forget, nullptr);
    return buffer;
}

bool has_memory() {
    return is_gpu() && record().settings.external_memory;
}
bool has_semaphores() {
    return has_memory() && record().settings.external_semaphores;
}

/// Acquires or releases.
cl_int hand_over(bool is_acquired, cl_command_queue queue, cl_uint count, const cl_mem* buffers, cl_uint waits,
                 const cl_event* wait_list, cl_event* event) {
    if ((count == 0) != (buffers == nullptr)) return CL_INVALID_VALUE;
    {
        const std::scoped_lock lock(externals().mutex);
        for (cl_uint n = 0; n < count; ++n)
            if (!externals().all.contains(buffers[n])) return CL_INVALID_MEM_OBJECT;
        for (cl_uint n = 0; n < count; ++n) externals().all[buffers[n]].is_acquired = is_acquired;
    }
    return CLSDF_NEXT(clEnqueueMarkerWithWaitList)(queue, waits, wait_list, event);
}

cl_int acquire(cl_command_queue queue, cl_uint count, const cl_mem* buffers, cl_uint waits, const cl_event* wait_list,
               cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueAcquireExternalMemObjectsKHR")) return code;
    return hand_over(true, queue, count, buffers, waits, wait_list, event);
}

cl_int release(cl_command_queue queue, cl_uint count, const cl_mem* buffers, cl_uint waits, const cl_event* wait_list,
               cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueReleaseExternalMemObjectsKHR")) return code;
    return hand_over(false, queue, count, buffers, waits, wait_list, event);
}

Semaphore* create_semaphore(cl_context context, const Properties* properties, cl_int* error) {
    const InCall in_call;
    if (const cl_int code = begin("clCreateSemaphoreWithPropertiesKHR")) return refused(code, error);
    bool is_binary = false, is_exported = false;
    for (const Properties* at = properties; at != nullptr && *at != 0;) {
        if (*at == semaphore_type) {
            is_binary = at[1] == binary;
            at += 2;
        } else if (*at == semaphore_export) {
            for (++at; *at != 0; ++at) is_exported |= *at == opaque_semaphore;
            ++at;
        } else {
            return refused(CL_INVALID_PROPERTY, error);
        }
    }
    if (!is_binary) return refused(CL_INVALID_VALUE, error);
    const int descriptor = is_exported ? ::eventfd(0, EFD_CLOEXEC) : -1;
    if (is_exported && descriptor < 0) return refused(CL_OUT_OF_HOST_MEMORY, error);
    if (error != nullptr) *error = CL_SUCCESS;
    return new Semaphore{context, std::make_shared<Payload>(descriptor)};
}

cl_int release_semaphore(Semaphore* semaphore) {
    if (semaphore == nullptr) return invalid_semaphore;
    if (--semaphore->owners == 0) delete semaphore;
    return CL_SUCCESS;
}

cl_int semaphore_handle(Semaphore* semaphore, cl_device_id, cl_uint type, std::size_t size, void* value,
                        std::size_t* needed) {
    const InCall in_call;
    if (const cl_int code = begin("clGetSemaphoreHandleForTypeKHR")) return code;
    if (semaphore == nullptr) return invalid_semaphore;
    if (type != opaque_semaphore || (value != nullptr && size < sizeof(int))) return CL_INVALID_VALUE;
    if (needed != nullptr) *needed = sizeof(int);
    if (value == nullptr) return CL_SUCCESS;
    const int copy = record().settings.unshared_semaphores
                         ? ::eventfd(0, EFD_CLOEXEC)
                         : ::fcntl(semaphore->payload->descriptor, F_DUPFD_CLOEXEC, 0);
    if (copy < 0) return CL_OUT_OF_RESOURCES;
    std::memcpy(value, &copy, sizeof copy);
    return CL_SUCCESS;
}

/// The queue goes on when the semaphore has been signalled, and it is not signalled then.
cl_int wait_semaphores(cl_command_queue queue, cl_uint count, Semaphore* const* semaphores, const cl_ulong*,
                       cl_uint waits, const cl_event* wait_list, cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueWaitSemaphoresKHR")) return code;
    if (count == 0 || semaphores == nullptr) return CL_INVALID_VALUE;
    std::vector<cl_event> before(wait_list, wait_list + waits);
    for (cl_uint n = 0; n < count; ++n) {
        cl_int code = CL_SUCCESS;
        const cl_event signalled = CLSDF_NEXT(clCreateUserEvent)(semaphores[n]->context, &code);
        if (code != CL_SUCCESS) return code;
        before.push_back(signalled);
        CLSDF_NEXT(clRetainEvent)(signalled);
        const std::shared_ptr<Payload> payload = semaphores[n]->payload;
        std::uint64_t number = 0;
        {
            const std::scoped_lock lock(payload->mutex);
            number = payload->enqueued++;
        }
        std::thread([payload, number, signalled] {
            {
                std::unique_lock lock(payload->mutex);
                payload->changed.wait(lock, [&] { return payload->ended == number; });
            }
            std::uint64_t value = 0;
            const bool is_read = ::read(payload->descriptor, &value, sizeof value) == sizeof value;
            {
                const std::scoped_lock lock(payload->mutex);
                ++payload->ended;
                payload->changed.notify_all();
            }
            CLSDF_NEXT(clSetUserEventStatus)(signalled, is_read ? CL_COMPLETE : CL_INVALID_OPERATION);
            CLSDF_NEXT(clReleaseEvent)(signalled);
        }).detach();
    }
    const cl_int code =
        CLSDF_NEXT(clEnqueueBarrierWithWaitList)(queue, static_cast<cl_uint>(before.size()), before.data(), event);
    for (std::size_t n = waits; n < before.size(); ++n) CLSDF_NEXT(clReleaseEvent)(before[n]);
    CLSDF_NEXT(clFlush)(queue);
    return code;
}

void CL_CALLBACK signal(cl_event event, cl_int, void* payload) {
    const std::unique_ptr<std::shared_ptr<Payload>> own(static_cast<std::shared_ptr<Payload>*>(payload));
    const std::uint64_t one = 1;
    if (::write((*own)->descriptor, &one, sizeof one) < 0) errno = 0;
    CLSDF_NEXT(clReleaseEvent)(event);
}

cl_int signal_semaphores(cl_command_queue queue, cl_uint count, Semaphore* const* semaphores, const cl_ulong*,
                         cl_uint waits, const cl_event* wait_list, cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueSignalSemaphoresKHR")) return code;
    if (count == 0 || semaphores == nullptr) return CL_INVALID_VALUE;
    cl_event reached = nullptr;
    if (const cl_int code = CLSDF_NEXT(clEnqueueMarkerWithWaitList)(queue, waits, wait_list, &reached)) return code;
    for (cl_uint n = 0; n < count; ++n) {
        CLSDF_NEXT(clRetainEvent)(reached);
        CLSDF_NEXT(clSetEventCallback)
        (reached, CL_COMPLETE, signal, new std::shared_ptr<Payload>(semaphores[n]->payload));
    }
    if (event != nullptr)
        *event = reached;
    else
        CLSDF_NEXT(clReleaseEvent)(reached);
    return CL_SUCCESS;
}

template <class Value>
cl_int answer(const Value& value, std::size_t bytes, std::size_t size, void* target, std::size_t* needed) {
    if (needed != nullptr) *needed = bytes;
    if (target == nullptr) return CL_SUCCESS;
    if (size < bytes) return CL_INVALID_VALUE;
    std::memcpy(target, &value, bytes);
    return CL_SUCCESS;
}

}  // namespace

std::optional<cl_int> external_answer(cl_device_info question, std::size_t size, void* value, std::size_t* needed) {
    if (!has_memory()) return std::nullopt;
    const cl_uint memory = opaque_memory, semaphore = opaque_semaphore;
    if (question == device_uuid) return answer(*uuid, sizeof uuid - 1, size, value, needed);
    if (question == import_memory) return answer(memory, sizeof memory, size, value, needed);
    if (question == export_semaphores && has_semaphores())
        return answer(semaphore, sizeof semaphore, size, value, needed);
    return std::nullopt;
}

std::string external_extensions() {
    std::string names;
    if (has_memory()) names += " cl_khr_device_uuid cl_khr_external_memory cl_khr_external_memory_opaque_fd";
    if (has_semaphores()) names += " cl_khr_semaphore cl_khr_external_semaphore cl_khr_external_semaphore_opaque_fd";
    return names;
}

bool is_external(cl_mem buffer) {
    const std::scoped_lock lock(externals().mutex);
    return externals().all.contains(buffer);
}

bool is_usable(cl_mem buffer) {
    const std::scoped_lock lock(externals().mutex);
    const auto found = externals().all.find(buffer);
    return found == externals().all.end() || found->second.is_acquired;
}

}  // namespace clsdf::disguise

using namespace clsdf::disguise;

extern "C" {

cl_mem clCreateBufferWithProperties(cl_context context, const Properties* properties, cl_mem_flags flags,
                                    std::size_t bytes, void* host, cl_int* error) {
    const InCall in_call;
    if (const cl_int code = begin("clCreateBufferWithProperties")) return refused(code, error);
    if (!has_memory() || properties == nullptr || *properties == 0)
        return CLSDF_NEXT(clCreateBufferWithProperties)(context, properties, flags, bytes, host, error);
    // These devices need no other property, and they refuse a DMA-BUF as NVIDIA's driver does.
    if (properties[0] == dma_buffer || properties[0] != opaque_memory || properties[2] != 0)
        return refused(CL_INVALID_PROPERTY, error);
    if ((flags & (CL_MEM_USE_HOST_PTR | CL_MEM_ALLOC_HOST_PTR | CL_MEM_COPY_HOST_PTR)) != 0)
        return refused(CL_INVALID_VALUE, error);
    if (host != nullptr) return refused(CL_INVALID_HOST_PTR, error);
    if (bytes == 0) return refused(CL_INVALID_BUFFER_SIZE, error);
    return import(context, static_cast<int>(properties[1]), bytes, error);
}

void* clGetExtensionFunctionAddressForPlatform(cl_platform_id platform, const char* name) {
    const std::map<std::string_view, void*> memory{
        {"clEnqueueAcquireExternalMemObjectsKHR", reinterpret_cast<void*>(acquire)},
        {"clEnqueueReleaseExternalMemObjectsKHR", reinterpret_cast<void*>(release)},
    };
    const std::map<std::string_view, void*> semaphores{
        {"clCreateSemaphoreWithPropertiesKHR", reinterpret_cast<void*>(create_semaphore)},
        {"clReleaseSemaphoreKHR", reinterpret_cast<void*>(release_semaphore)},
        {"clGetSemaphoreHandleForTypeKHR", reinterpret_cast<void*>(semaphore_handle)},
        {"clEnqueueWaitSemaphoresKHR", reinterpret_cast<void*>(wait_semaphores)},
        {"clEnqueueSignalSemaphoresKHR", reinterpret_cast<void*>(signal_semaphores)},
    };
    if (const auto found = memory.find(name); has_memory() && found != memory.end()) return found->second;
    if (const auto found = semaphores.find(name); has_semaphores() && found != semaphores.end()) return found->second;
    return CLSDF_NEXT(clGetExtensionFunctionAddressForPlatform)(platform, name);
}
}

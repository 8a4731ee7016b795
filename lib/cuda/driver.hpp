#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

/// The part of CUDA's driver that clsdf::cuda uses, by the names and the types of cuda.h. Nothing of CUDA is needed at
/// build time, and libcuda.so.1 is opened by the first call of driver().
namespace clsdf::cuda {

using Pointer = std::uint64_t;    ///< CUdeviceptr
using Allocated = std::uint64_t;  ///< CUmemGenericAllocationHandle
using ContextHandle = void*;      ///< CUcontext
using Stream = void*;             ///< CUstream
using Event = void*;              ///< CUevent
using Semaphore = void*;          ///< CUexternalSemaphore

/// A stream as it is kept: the default stream has two names, null and CU_STREAM_LEGACY.
inline Stream named(Stream stream) {
    return stream != nullptr ? stream : reinterpret_cast<Stream>(1);
}

struct Location {
    int type = 1;  // CU_MEM_LOCATION_TYPE_DEVICE
    int id = 0;
};
struct AllocationProperties {
    int type = 1;               // CU_MEM_ALLOCATION_TYPE_PINNED
    int requested_handles = 1;  // CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR
    Location location;
    void* win32 = nullptr;
    unsigned char compression = 0, rdma = 0;
    unsigned short usage = 0;
    unsigned char reserved[4]{};
};
static_assert(sizeof(AllocationProperties) == 32);
struct Accessibility {
    Location location;
    int flags = 3;  // CU_MEM_ACCESS_FLAGS_PROT_READWRITE
};
static_assert(sizeof(Accessibility) == 12);
struct SemaphoreDescription {
    int type = 1;  // CU_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD
    alignas(8) int descriptor = -1;
    alignas(8) void* win32_name = nullptr;
    unsigned flags = 0;
    unsigned reserved[16]{};
};
static_assert(sizeof(SemaphoreDescription) == 96 && offsetof(SemaphoreDescription, flags) == 24);
/// Those of a signal and of a wait have the same size, and are zeros for a binary semaphore.
struct alignas(8) SemaphoreParameters {
    unsigned zeros[36]{};
};
static_assert(sizeof(SemaphoreParameters) == 144);

// member, name of the function, parameters
#define CLSDF_CUDA_FUNCTIONS(X)                                                                                      \
    X(init, cuInit, (unsigned flags))                                                                                \
    X(device_count, cuDeviceGetCount, (int* count))                                                                  \
    X(device, cuDeviceGet, (int* device, int ordinal))                                                               \
    X(device_name, cuDeviceGetName, (char* name, int length, int device))                                            \
    X(uuid, cuDeviceGetUuid_v2, (void* uuid, int device))                                                            \
    X(retain_primary, cuDevicePrimaryCtxRetain, (ContextHandle * context, int device))                               \
    X(release_primary, cuDevicePrimaryCtxRelease_v2, (int device))                                                   \
    X(push, cuCtxPushCurrent_v2, (ContextHandle context))                                                            \
    X(pop, cuCtxPopCurrent_v2, (ContextHandle * context))                                                            \
    X(synchronize, cuCtxSynchronize, ())                                                                             \
    X(granularity, cuMemGetAllocationGranularity, (std::size_t * bytes, const AllocationProperties*, int option))    \
    X(create, cuMemCreate, (Allocated * handle, std::size_t bytes, const AllocationProperties*, unsigned long long)) \
    X(release, cuMemRelease, (Allocated handle))                                                                     \
    X(export_handle, cuMemExportToShareableHandle, (void* out, Allocated handle, int type, unsigned long long))      \
    X(reserve, cuMemAddressReserve,                                                                                  \
      (Pointer * address, std::size_t bytes, std::size_t alignment, Pointer wanted, unsigned long long))             \
    X(unreserve, cuMemAddressFree, (Pointer address, std::size_t bytes))                                             \
    X(map, cuMemMap, (Pointer address, std::size_t bytes, std::size_t offset, Allocated, unsigned long long))        \
    X(unmap, cuMemUnmap, (Pointer address, std::size_t bytes))                                                       \
    X(set_access, cuMemSetAccess, (Pointer address, std::size_t bytes, const Accessibility*, std::size_t count))     \
    X(pointer_attribute, cuPointerGetAttribute, (void* value, int attribute, Pointer address))                       \
    X(copy, cuMemcpyDtoDAsync_v2, (Pointer to, Pointer from, std::size_t bytes, Stream))                             \
    X(copy_up, cuMemcpyHtoDAsync_v2, (Pointer to, const void* from, std::size_t bytes, Stream))                      \
    X(copy_down, cuMemcpyDtoHAsync_v2, (void* to, Pointer from, std::size_t bytes, Stream))                          \
    X(create_stream, cuStreamCreate, (Stream * stream, unsigned flags))                                              \
    X(destroy_stream, cuStreamDestroy_v2, (Stream stream))                                                           \
    X(finish_stream, cuStreamSynchronize, (Stream stream))                                                           \
    X(wait_event, cuStreamWaitEvent, (Stream stream, Event event, unsigned flags))                                   \
    X(create_event, cuEventCreate, (Event * event, unsigned flags))                                                  \
    X(destroy_event, cuEventDestroy_v2, (Event event))                                                               \
    X(record_event, cuEventRecord, (Event event, Stream stream))                                                     \
    X(query_event, cuEventQuery, (Event event))                                                                      \
    X(finish_event, cuEventSynchronize, (Event event))                                                               \
    X(import_semaphore, cuImportExternalSemaphore, (Semaphore * semaphore, const SemaphoreDescription*))             \
    X(destroy_semaphore, cuDestroyExternalSemaphore, (Semaphore semaphore))                                          \
    X(signal, cuSignalExternalSemaphoresAsync,                                                                       \
      (const Semaphore* semaphores, const SemaphoreParameters*, unsigned count, Stream))                             \
    X(wait, cuWaitExternalSemaphoresAsync,                                                                           \
      (const Semaphore* semaphores, const SemaphoreParameters*, unsigned count, Stream))                             \
    X(error_name, cuGetErrorName, (int code, const char** name))

struct Driver {
#define CLSDF_CUDA_MEMBER(member, function, parameters) int(*member) parameters = nullptr;
    CLSDF_CUDA_FUNCTIONS(CLSDF_CUDA_MEMBER)
#undef CLSDF_CUDA_MEMBER
};

/// Opens the driver at the first call. Throws Error(no_device) with the reason and the remedy if there is none.
const Driver& driver();

/// Throws Error(out_of_memory) or Error(device_failure) that names the call, unless the code is 0.
void check(int code, const char* call);

/// A context is the current one of this thread, as long as this lives.
class Current {
public:
    explicit Current(ContextHandle context) { check(driver().push(context), "cuCtxPushCurrent"); }
    ~Current() {
        ContextHandle before = nullptr;
        driver().pop(&before);
    }
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
};

}  // namespace clsdf::cuda

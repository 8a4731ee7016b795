#include "disguise/cuda/driver.hpp"

#include "disguise/external.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace clsdf::cuda_stand_in {

struct Memory {
    int descriptor = -1;
    std::byte* address = nullptr;
    std::size_t size = 0;
    int device = 0;
    bool is_exportable = false;

    ~Memory() {
        if (address != nullptr) ::munmap(address, size);
        if (descriptor >= 0) ::close(descriptor);
    }
};

namespace {

struct Mapping {
    std::size_t size;
    std::shared_ptr<Memory> memory;
    bool is_accessible;
};

struct Driver {
    std::mutex mutex;
    bool is_initialized = false;
    std::map<std::string, int> calls;
    std::pair<std::string, int> delayed;  ///< a call and its number
    std::map<std::uint64_t, std::size_t> reservations;
    std::map<std::uint64_t, Mapping> mappings;
    std::map<std::uint64_t, std::shared_ptr<Memory>> handles;
    std::uint64_t next_handle = 1;
    std::array<int, 2> owners{};  ///< of the primary contexts
};
Driver& driver() {
    static auto* const only = new Driver;
    return *only;
}

thread_local std::vector<void*> contexts;

/// A context's handle is the address of its number of owners.
int device_of(void* context) {
    return static_cast<int>(static_cast<int*>(context) - driver().owners.data());
}

int device_count() {
    const char* const text = std::getenv("CLSDF_CUDA_DEVICES");
    return text == nullptr ? 2 : std::atoi(text);
}

const char* uuid_of(int device) {
    return device == 1 ? disguise::uuid : "another-device-0";
}

/// The mapping that has the whole range, under the mutex; null if there is none.
std::pair<const std::uint64_t, Mapping>* mapping_at(std::uint64_t address, std::size_t size) {
    auto& all = driver().mappings;
    auto after = all.upper_bound(address);
    if (after == all.begin()) return nullptr;
    auto& found = *--after;
    return address + size <= found.first + found.second.size ? &found : nullptr;
}

std::shared_ptr<Memory> new_memory(std::size_t size, int device) {
    auto memory = std::make_shared<Memory>();
    const std::string name = std::string("cuda-") + uuid_of(device);
    memory->descriptor = ::memfd_create(name.c_str(), MFD_CLOEXEC);
    if (memory->descriptor < 0 || ::ftruncate(memory->descriptor, static_cast<off_t>(size)) != 0) return nullptr;
    void* const address = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memory->descriptor, 0);
    if (address == MAP_FAILED) return nullptr;
    memory->address = static_cast<std::byte*>(address);
    memory->size = size;
    memory->device = device;
    return memory;
}

std::uint64_t reserve(std::size_t size) {
    void* const address = ::mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    return address == MAP_FAILED ? 0 : reinterpret_cast<std::uint64_t>(address);
}

/// Whether the variable, CALL:NUMBER, names the latest call, under the mutex.
bool is_named(const char* variable, const char* call) {
    const char* const text = std::getenv(variable);
    if (text == nullptr) return false;
    const std::string named = text;
    const std::size_t colon = named.find(':');
    return named.substr(0, colon) == call && driver().calls[call] == std::atoi(named.c_str() + colon + 1);
}

}  // namespace

Result begin(const char* call) {
    std::unique_lock lock(driver().mutex);
    ++driver().calls[call];
    if (is_named("CLSDF_CUDA_FAULT", call)) return unknown;
    if (driver().delayed == std::pair(std::string(call), driver().calls[call])) {
        lock.unlock();
        std::this_thread::sleep_for(std::chrono::seconds(1));
        lock.lock();
    }
    return driver().is_initialized ? success : not_initialized;
}

Result begin_in_context(const char* call) {
    if (const Result code = begin(call)) return code;
    if (contexts.empty()) return invalid_context;
    const std::scoped_lock lock(driver().mutex);
    return *static_cast<int*>(contexts.back()) > 0 ? success : invalid_context;
}

Bytes bytes_at(std::uint64_t address, std::size_t size) {
    const std::scoped_lock lock(driver().mutex);
    const auto* const found = mapping_at(address, size);
    if (found == nullptr || !found->second.is_accessible) return {};
    return {found->second.memory->address + (address - found->first), found->second.memory};
}

}  // namespace clsdf::cuda_stand_in

using namespace clsdf::cuda_stand_in;

namespace {

struct Location {
    int type, id;
};
struct AllocationProperties {
    int type, requested_handles;
    Location location;
    void* win32;
    unsigned char compression, rdma;
    unsigned short usage;
    unsigned char reserved[4];
};
static_assert(sizeof(AllocationProperties) == 32);
struct Access {
    Location location;
    int flags;
};

bool is_known(const AllocationProperties* properties) {
    return properties != nullptr && properties->type == 1 && properties->location.type == 1 &&
           properties->location.id >= 0 && properties->location.id < device_count() && properties->win32 == nullptr;
}

}  // namespace

extern "C" {

Result cuInit(unsigned flags) {
    if (flags != 0) return invalid_value;
    begin("cuInit");
    if (device_count() == 0) return no_device;
    const std::scoped_lock lock(driver().mutex);
    driver().is_initialized = true;
    return success;
}

Result cuGetErrorName(Result code, const char** name) {
    static const std::map<Result, const char*> names{{success, "CUDA_SUCCESS"},
                                                     {invalid_value, "CUDA_ERROR_INVALID_VALUE"},
                                                     {out_of_memory, "CUDA_ERROR_OUT_OF_MEMORY"},
                                                     {not_initialized, "CUDA_ERROR_NOT_INITIALIZED"},
                                                     {no_device, "CUDA_ERROR_NO_DEVICE"},
                                                     {invalid_device, "CUDA_ERROR_INVALID_DEVICE"},
                                                     {invalid_context, "CUDA_ERROR_INVALID_CONTEXT"},
                                                     {invalid_handle, "CUDA_ERROR_INVALID_HANDLE"},
                                                     {not_supported, "CUDA_ERROR_NOT_SUPPORTED"},
                                                     {unknown, "CUDA_ERROR_UNKNOWN"}};
    const auto found = names.find(code);
    *name = found == names.end() ? nullptr : found->second;
    return found == names.end() ? invalid_value : success;
}

Result cuDeviceGetCount(int* count) {
    if (const Result code = begin("cuDeviceGetCount")) return code;
    *count = device_count();
    return success;
}

Result cuDeviceGet(int* device, int ordinal) {
    if (const Result code = begin("cuDeviceGet")) return code;
    if (ordinal < 0 || ordinal >= device_count()) return invalid_device;
    *device = ordinal;
    return success;
}

Result cuDeviceGetName(char* name, int length, int device) {
    if (const Result code = begin("cuDeviceGetName")) return code;
    const std::string text = "stand-in " + std::to_string(device);
    std::strncpy(name, text.c_str(), static_cast<std::size_t>(length));
    return success;
}

Result cuDeviceGetUuid_v2(char* uuid, int device) {
    if (const Result code = begin("cuDeviceGetUuid_v2")) return code;
    if (device < 0 || device >= device_count()) return invalid_device;
    std::memcpy(uuid, uuid_of(device), 16);
    return success;
}

Result cuDevicePrimaryCtxRetain(void** context, int device) {
    if (const Result code = begin("cuDevicePrimaryCtxRetain")) return code;
    if (device < 0 || device >= device_count()) return invalid_device;
    const std::scoped_lock lock(driver().mutex);
    ++driver().owners[static_cast<std::size_t>(device)];
    *context = &driver().owners[static_cast<std::size_t>(device)];
    return success;
}

Result cuDevicePrimaryCtxRelease_v2(int device) {
    if (const Result code = begin("cuDevicePrimaryCtxRelease_v2")) return code;
    const std::scoped_lock lock(driver().mutex);
    int& owners = driver().owners[static_cast<std::size_t>(device)];
    if (owners == 0) return invalid_context;
    --owners;
    return success;
}

/// For tests: the owners of a device's primary context.
int cuda_stand_in_owners(int device) {
    const std::scoped_lock lock(driver().mutex);
    return driver().owners[static_cast<std::size_t>(device)];
}

/// For tests: how often a function was called.
int cuda_stand_in_calls(const char* call) {
    const std::scoped_lock lock(driver().mutex);
    return driver().calls[call];
}

void cuda_stand_in_delay(const char* call, int number) {
    const std::scoped_lock lock(driver().mutex);
    driver().delayed = {call, number};
}

Result cuCtxPushCurrent_v2(void* context) {
    if (const Result code = begin("cuCtxPushCurrent_v2")) return code;
    if (context == nullptr) return invalid_context;
    contexts.push_back(context);
    return success;
}

Result cuCtxPopCurrent_v2(void** context) {
    if (const Result code = begin("cuCtxPopCurrent_v2")) return code;
    if (contexts.empty()) return invalid_context;
    if (context != nullptr) *context = contexts.back();
    contexts.pop_back();
    return success;
}

Result cuCtxGetCurrent(void** context) {
    *context = contexts.empty() ? nullptr : contexts.back();
    return success;
}

Result cuCtxSynchronize() {
    if (const Result code = begin_in_context("cuCtxSynchronize")) return code;
    finish_all();
    return success;
}

Result cuMemGetAllocationGranularity(std::size_t* size, const AllocationProperties* properties, int option) {
    if (const Result code = begin("cuMemGetAllocationGranularity")) return code;
    if (!is_known(properties) || option < 0 || option > 1) return invalid_value;
    *size = granularity;
    return success;
}

Result cuMemCreate(std::uint64_t* handle, std::size_t size, const AllocationProperties* properties,
                   unsigned long long flags) {
    if (const Result code = begin("cuMemCreate")) return code;
    if (!is_known(properties) || size == 0 || size % granularity != 0 || flags != 0) return invalid_value;
    if (properties->requested_handles > 1) return not_supported;
    std::shared_ptr<Memory> memory = new_memory(size, properties->location.id);
    if (memory == nullptr) return out_of_memory;
    memory->is_exportable = properties->requested_handles == 1;
    const std::scoped_lock lock(driver().mutex);
    *handle = driver().next_handle++;
    driver().handles.emplace(*handle, std::move(memory));
    return success;
}

Result cuMemRelease(std::uint64_t handle) {
    if (const Result code = begin("cuMemRelease")) return code;
    const std::scoped_lock lock(driver().mutex);
    return driver().handles.erase(handle) == 1 ? success : invalid_value;
}

Result cuMemExportToShareableHandle(void* exported, std::uint64_t handle, int type, unsigned long long flags) {
    if (const Result code = begin("cuMemExportToShareableHandle")) return code;
    const std::scoped_lock lock(driver().mutex);
    const auto found = driver().handles.find(handle);
    if (found == driver().handles.end() || flags != 0) return invalid_value;
    if (type != 1 || !found->second->is_exportable) return not_permitted;
    const int copy = ::fcntl(found->second->descriptor, F_DUPFD_CLOEXEC, 0);
    if (copy < 0) return unknown;
    std::memcpy(exported, &copy, sizeof copy);
    return success;
}

Result cuMemAddressReserve(std::uint64_t* address, std::size_t size, std::size_t alignment, std::uint64_t wanted,
                           unsigned long long flags) {
    if (const Result code = begin("cuMemAddressReserve")) return code;
    if (size == 0 || size % granularity != 0 || alignment > granularity || wanted != 0 || flags != 0)
        return invalid_value;
    const std::uint64_t found = reserve(size);
    if (found == 0) return out_of_memory;
    const std::scoped_lock lock(driver().mutex);
    driver().reservations[found] = size;
    *address = found;
    return success;
}

Result cuMemAddressFree(std::uint64_t address, std::size_t size) {
    if (const Result code = begin("cuMemAddressFree")) return code;
    const std::scoped_lock lock(driver().mutex);
    const auto found = driver().reservations.find(address);
    if (found == driver().reservations.end() || found->second != size || driver().mappings.contains(address))
        return invalid_value;
    ::munmap(reinterpret_cast<void*>(address), size);
    driver().reservations.erase(found);
    return success;
}

Result cuMemMap(std::uint64_t address, std::size_t size, std::size_t offset, std::uint64_t handle,
                unsigned long long flags) {
    if (const Result code = begin("cuMemMap")) return code;
    const std::scoped_lock lock(driver().mutex);
    const auto memory = driver().handles.find(handle);
    const auto room = driver().reservations.find(address);
    if (memory == driver().handles.end() || room == driver().reservations.end() || room->second < size ||
        memory->second->size != size || offset != 0 || flags != 0 || driver().mappings.contains(address))
        return invalid_value;
    driver().mappings.emplace(address, Mapping{size, memory->second, false});
    return success;
}

Result cuMemUnmap(std::uint64_t address, std::size_t size) {
    if (const Result code = begin("cuMemUnmap")) return code;
    const std::scoped_lock lock(driver().mutex);
    const auto found = driver().mappings.find(address);
    if (found == driver().mappings.end() || found->second.size != size) return invalid_value;
    driver().mappings.erase(found);
    return success;
}

Result cuMemSetAccess(std::uint64_t address, std::size_t size, const Access* access, std::size_t count) {
    if (const Result code = begin("cuMemSetAccess")) return code;
    const std::scoped_lock lock(driver().mutex);
    const auto found = driver().mappings.find(address);
    if (found == driver().mappings.end() || found->second.size != size || count != 1 || access->location.type != 1)
        return invalid_value;
    if (access->location.id != found->second.memory->device) return invalid_device;
    found->second.is_accessible = access->flags == 3;
    return success;
}

Result cuMemAlloc_v2(std::uint64_t* address, std::size_t size) {
    if (const Result code = begin_in_context("cuMemAlloc_v2")) return code;
    if (size == 0) return invalid_value;
    std::shared_ptr<Memory> memory = new_memory(size, device_of(contexts.back()));
    const std::uint64_t found = memory == nullptr ? 0 : reserve(size);
    if (found == 0) return out_of_memory;
    const std::scoped_lock lock(driver().mutex);
    driver().reservations[found] = size;
    driver().mappings.emplace(found, Mapping{size, std::move(memory), true});
    *address = found;
    return success;
}

Result cuMemFree_v2(std::uint64_t address) {
    if (const Result code = begin_in_context("cuMemFree_v2")) return code;
    finish_all();
    const std::scoped_lock lock(driver().mutex);
    const auto found = driver().mappings.find(address);
    if (found == driver().mappings.end()) return invalid_value;
    ::munmap(reinterpret_cast<void*>(address), found->second.size);
    driver().reservations.erase(address);
    driver().mappings.erase(found);
    return success;
}

Result cuPointerGetAttribute(void* value, int attribute, std::uint64_t address) {
    if (const Result code = begin("cuPointerGetAttribute")) return code;
    constexpr int device_ordinal = 9;
    if (attribute != device_ordinal) return not_supported;
    const std::scoped_lock lock(driver().mutex);
    const auto* const found = mapping_at(address, 1);
    if (found == nullptr) return invalid_value;
    std::memcpy(value, &found->second.memory->device, sizeof(int));
    return success;
}
}

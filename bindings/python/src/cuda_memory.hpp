#pragma once

#include "cuda_driver.hpp"

#include <clsdf/device.hpp>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::python::cuda {

/// An event of OpenCL, or none.
class ClEvent {
public:
    ClEvent() = default;
    ClEvent(ClEvent&& other) noexcept : event_(std::exchange(other.event_, nullptr)) {}
    ClEvent& operator=(ClEvent&& other) noexcept {
        std::swap(event_, other.event_);
        return *this;
    }
    ~ClEvent() {
        if (event_ != nullptr) clReleaseEvent(event_);
    }

    cl_event* put() { return &event_; }
    std::span<const cl_event> list() const { return {&event_, event_ == nullptr ? 0U : 1U}; }
    cl_event release() { return std::exchange(event_, nullptr); }
    void wait() const;

private:
    cl_event event_ = nullptr;
};

/// Throws Error(device_failure) that names the call, unless the code is CL_SUCCESS.
void check_cl(cl_int code, const char* call);

class Link;

/// Memory of the device that CUDA made, and that is a buffer of OpenCL, too.
class Allocation {
public:
    /// At least so many bytes. Throws Error(out_of_memory), Error(device_failure), and as Device::import_memory().
    Allocation(Link& link, std::size_t bytes);
    ~Allocation();  ///< waits for the device, as cudaFree() does
    Allocation(const Allocation&) = delete;
    Allocation& operator=(const Allocation&) = delete;

    Pointer address() const { return address_; }
    std::size_t bytes() const { return bytes_; }
    cl_mem buffer() const { return buffer_; }

private:
    void free() noexcept;

    Link& link_;
    Pointer address_ = 0;
    std::size_t bytes_ = 0;
    bool is_mapped_ = false;
    cl_mem buffer_ = nullptr;
};

/// A binary semaphore that OpenCL made and CUDA has imported.
struct SharedSemaphore {
    explicit SharedSemaphore(const Link& link);
    ~SharedSemaphore();
    SharedSemaphore(const SharedSemaphore&) = delete;
    SharedSemaphore& operator=(const SharedSemaphore&) = delete;

    const Link& link;
    struct _cl_semaphore_khr* of_opencl = nullptr;
    Semaphore of_cuda = nullptr;
};

/// One for each direction.
struct Semaphores {
    explicit Semaphores(const Link& link) : to_opencl(link), to_cuda(link) {}
    SharedSemaphore to_opencl, to_cuda;
};

/// Objects that one call at a time uses: events, staging memory, semaphores. The next user waits on the device for
/// `latest`.
struct Lane {
    explicit Lane(Link& link);
    ~Lane();
    Lane(const Lane&) = delete;
    Lane& operator=(const Lane&) = delete;

    Link& link;
    Event latest = nullptr;  ///< recorded when the latest user was done
    bool is_recorded = false;
    Event crossing = nullptr;  ///< between streams of one call
    std::unique_ptr<Allocation> staging{};
    std::unique_ptr<Semaphores> semaphores{};  ///< made at the first use
};

/// The functions of the extensions, null if the driver has them not.
struct Extensions {
    using HandOver = cl_int(CL_API_CALL*)(cl_command_queue, cl_uint, const cl_mem*, cl_uint, const cl_event*,
                                          cl_event*);
    using CrossSemaphores = cl_int(CL_API_CALL*)(cl_command_queue, cl_uint, _cl_semaphore_khr* const*, const cl_ulong*,
                                                 cl_uint, const cl_event*, cl_event*);
    HandOver acquire = nullptr, release = nullptr;
    CrossSemaphores wait = nullptr, signal = nullptr;
    _cl_semaphore_khr*(CL_API_CALL* create)(cl_context, const cl_ulong*, cl_int*) = nullptr;
    cl_int(CL_API_CALL* destroy)(_cl_semaphore_khr*) = nullptr;
    cl_int(CL_API_CALL* handle)(_cl_semaphore_khr*, cl_device_id, cl_uint, std::size_t, void*, std::size_t*) = nullptr;
};

/// A device of OpenCL, and the same one of CUDA. Retains its primary context. Thread-safe.
class Link {
public:
    /// Throws Error(unsupported) if the device shares no memory, Error(no_device) if CUDA has no driver or no device of
    /// the same UUID.
    explicit Link(const Device& device);
    ~Link();
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    const Device& device() const { return device_; }
    int ordinal() const { return ordinal_; }
    ContextHandle context() const { return context_; }
    const Extensions& extensions() const { return extensions_; }

    /// Whether CUDA and OpenCL wait for each other's semaphores: tried out at the first call.
    bool has_semaphores();

    /// With staging memory of at least so many bytes.
    std::unique_ptr<Lane> take_lane(std::size_t bytes);
    void give_back(std::unique_ptr<Lane> lane) noexcept;
    /// Frees the staging memory that no call uses. Returns its bytes.
    std::size_t release_memory();

private:
    bool try_semaphores();

    Device device_;
    int ordinal_ = 0;
    int handle_ = 0;  ///< CUdevice
    ContextHandle context_ = nullptr;
    Extensions extensions_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Lane>> lanes_;
    std::once_flag is_tried_;
    bool has_semaphores_ = false;
};

/// The memory of a SharedArray. Calls that use it take turns.
class SharedMemory {
public:
    SharedMemory(std::shared_ptr<Link> link, std::size_t bytes) : link_(std::move(link)), allocation_(*link_, bytes) {}

    Link& link() const { return *link_; }
    const Allocation& allocation() const { return allocation_; }

    std::recursive_mutex mutex;  ///< held by a call; a callback of the call may make another one
    int depth = 0;               ///< of the calls that hold it

private:
    std::shared_ptr<Link> link_;
    Allocation allocation_;
};

std::shared_ptr<SharedMemory> new_shared_memory(std::shared_ptr<Link> link, std::size_t bytes);
/// The shared memory in which an address lies; null if it is none.
std::shared_ptr<SharedMemory> shared_memory_at(Pointer address);

}  // namespace clsdf::python::cuda

#pragma once

#include "cuda/driver.hpp"

#include "device/opencl_binding.hpp"

#include <clsdf/cuda.hpp>

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace clsdf::cuda {

/// Throws Error(out_of_memory) or Error(device_failure) that names the call, unless the code is CL_SUCCESS.
void check_cl(cl_int code, const char* call);

struct Lane;

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
    /// Throws as SharedDevice.
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

}  // namespace clsdf::cuda

#pragma once

#include "cuda/memory.hpp"

#include <memory>

namespace clsdf::cuda {

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

}  // namespace clsdf::cuda

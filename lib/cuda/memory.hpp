#pragma once

#include "cuda/link.hpp"

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>

namespace clsdf::cuda {

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

/// The memory of a SharedMemory. Calls that use it take turns.
class Block {
public:
    Block(std::shared_ptr<Link> link, std::size_t bytes) : link_(std::move(link)), allocation_(*link_, bytes) {}

    Link& link() const { return *link_; }
    const Allocation& allocation() const { return allocation_; }

    std::recursive_mutex mutex;  ///< held by a call; a callback of the call may make another one
    int depth = 0;               ///< of the calls that hold it

private:
    std::shared_ptr<Link> link_;
    Allocation allocation_;
};

/// The block in which an address lies; null if it is in none.
std::shared_ptr<Block> block_at(Pointer address);

}  // namespace clsdf::cuda

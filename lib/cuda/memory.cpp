#include "cuda/memory.hpp"

#include <clsdf/error.hpp>

#include <unistd.h>
#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace clsdf::cuda {

namespace {

constexpr int posix_descriptor = 1;  // CU_MEM_HANDLE_TYPE_POSIX_FILE_DESCRIPTOR

std::size_t rounded(std::size_t bytes, std::size_t granularity) {
    return (std::max<std::size_t>(bytes, 1) + granularity - 1) / granularity * granularity;
}

}  // namespace

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
        Accessibility access;
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

namespace {

struct Registry {
    std::mutex mutex;
    std::map<Pointer, std::weak_ptr<Block>> all;  ///< by the first address
};
Registry& registry() {
    static auto* const only = new Registry;
    return *only;
}

std::shared_ptr<Block> new_block(std::shared_ptr<Link> link, std::size_t bytes) {
    // The address leaves the registry before the memory is freed, so that no other memory has it.
    std::shared_ptr<Block> memory(new Block(std::move(link), bytes), [](Block* own) {
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

}  // namespace

std::shared_ptr<Block> block_at(Pointer address) {
    std::shared_ptr<Block> memory;  // ends after the lock: it may be the last owner, whose end takes the mutex
    const std::scoped_lock lock(registry().mutex);
    auto after = registry().all.upper_bound(address);
    if (after == registry().all.begin()) return nullptr;
    memory = std::prev(after)->second.lock();
    if (memory == nullptr || address >= memory->allocation().address() + memory->allocation().bytes()) return nullptr;
    return memory;
}

SharedMemory::SharedMemory(const SharedDevice& device, std::size_t bytes) : block_(new_block(device.link_, bytes)) {}

std::uint64_t SharedMemory::address() const {
    return block_->allocation().address();
}

std::size_t SharedMemory::bytes() const {
    return block_->allocation().bytes();
}

cl_mem SharedMemory::buffer() const {
    return block_->allocation().buffer();
}

}  // namespace clsdf::cuda

#pragma once

#include "device/context.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf::device {

/// Device buffers kept between computations: fresh memory costs page faults, many times what a kernel needs to fill it.
/// Plans may outlive their transform and end on another thread, so a mutex guards the free ones.
class BufferPool : public std::enable_shared_from_this<BufferPool> {
public:
    explicit BufferPool(std::shared_ptr<Context> context)
        : context_(std::move(context)), all_bytes_(std::make_shared<std::atomic<std::size_t>>(0)) {}
    ~BufferPool() { hand_back(); }
    BufferPool(const BufferPool&) = delete;
    BufferPool& operator=(const BufferPool&) = delete;

    /// A pool with buffers of its own. The device's memory limits both together.
    std::shared_ptr<BufferPool> beside() const {
        auto pool = std::make_shared<BufferPool>(context_);
        pool->all_bytes_ = all_bytes_;
        return pool;
    }

    // NOLINTBEGIN(bugprone-exception-escape): OpenCL's binding would throw from a move if a release fails
    /// A buffer of at least `bytes` bytes, its contents undefined, that goes back to the pool by itself. Commands in
    /// the context's queue may still use it then. The queue is in order: the next user enqueues there, or waits for it.
    /// If the context is lost, there is no next user.
    class Lease {
    public:
        Lease() = default;
        Lease(std::shared_ptr<BufferPool> pool, cl::Buffer buffer, std::size_t bytes)
            : pool_(std::move(pool)), buffer_(std::move(buffer)), bytes_(bytes) {}
        /// A buffer in memory of the host (buffer_in()), which it does not own.
        Lease(cl::Buffer buffer, const void* memory)
            : buffer_(std::move(buffer)),
              mapped_(const_cast<void*>(memory)) {}  // NOLINT(cppcoreguidelines-pro-type-const-cast): it is read only
        Lease(Lease&& other) noexcept { *this = std::move(other); }
        Lease& operator=(Lease&& other) noexcept;
        ~Lease() { give_back(); }

        const cl::Buffer& operator*() const { return buffer_; }
        std::size_t bytes() const { return bytes_; }

        /// The buffer's content in the host's memory, as long as the lease lasts: on a processor the buffer itself.
        /// From the first call on nothing may write to the buffer; kernels may read it. The first call waits for the
        /// queue, later ones are for any number of threads. Throws Error(device_failure or out_of_memory).
        const void* on_host() const;

    private:
        void give_back() noexcept;

        std::shared_ptr<BufferPool> pool_;
        cl::Buffer buffer_;
        std::size_t bytes_ = 0;
        mutable void* mapped_ = nullptr;
    };
    // NOLINTEND(bugprone-exception-escape)

    /// Throws Error(out_of_memory) that names `purpose` if the device cannot allocate so much at once.
    void check_size(std::size_t bytes, const char* purpose) const;

    /// Throws Error(out_of_memory) that names `purpose` if the device cannot allocate so much at once, or has not so
    /// much memory left.
    Lease lease(std::size_t bytes, const char* purpose);

    /// The same for lists, whose length changes when vertices move: a buffer that must be made gets an eighth more
    /// than asked for, if that fits, so that it serves longer lists, too.
    Lease lease_for_list(std::size_t bytes, const char* purpose);

    /// The same for an optional buffer: nothing if it does not fit.
    std::optional<Lease> lease_if_it_fits(std::size_t bytes, const char* purpose);

    /// Gives up the free buffers that were not in use since the last call: see Context::arena().
    void trim();
    /// Gives up all free buffers.
    void hand_back();

    /// Releases all free buffers and what the context keeps, because memory is short. Returns whether there were any.
    bool release();

    /// The most bytes that all buffers, free ones included, took at once since the last restart_peak().
    std::size_t peak() const;
    void restart_peak();

private:
    // NOLINTNEXTLINE(bugprone-exception-escape): as above
    struct Free {
        cl::Buffer buffer;
        std::size_t bytes;
        bool used = true;
    };

    std::optional<Lease> take_free(std::size_t wanted);
    std::size_t free_bytes() const;
    void forget(std::size_t bytes) { *all_bytes_ -= bytes; }
    bool release_free();
    /// Adds memory for small leases if the lease is small and there is room.
    bool add_block_for(std::size_t wanted);
    Lease lease_of(Arena::Part part);
    /// The arena gets the last of the free buffers.
    void give_up(std::span<Free> buffers);

    std::shared_ptr<Context> context_;
    mutable std::mutex mutex_;
    std::vector<Free> free_;
    std::size_t leased_bytes_ = 0;
    std::shared_ptr<std::atomic<std::size_t>> all_bytes_;  // of this pool and those beside it, free buffers included
    std::size_t peak_ = 0;
};

/// A buffer in `bytes` bytes of the host's memory. The driver shares the memory until no command uses the buffer any
/// more. Throws cl::Error.
cl::Buffer buffer_in(const Context& context, std::shared_ptr<const void> memory, std::size_t bytes,
                     cl_mem_flags access);

/// Few values that kernels read, copied at once: to write them to a buffer of the pool would wait for all that was
/// enqueued before. There must be one at least.
template <class Value>
cl::Buffer copied(const Context& context, const std::vector<Value>& values) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): it is read only
    auto* const data = const_cast<Value*>(values.data());
    return guarded([&] {
        return cl::Buffer(context.context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(Value),
                          data);
    });
}

/// A buffer that the host fills: in place, as on a processor, whose memory is the host's, or by way of an array that is
/// copied at the end.
class HostFilling {
public:
    HostFilling(const Context& context, std::shared_ptr<BufferPool> pool, std::size_t bytes, const char* purpose)
        : HostFilling(context, std::move(pool), bytes, purpose, context.capabilities().is_processor) {}
    HostFilling(const Context& context, std::shared_ptr<BufferPool> pool, std::size_t bytes, const char* purpose,
                bool in_place);
    HostFilling(const HostFilling&) = delete;
    HostFilling& operator=(const HostFilling&) = delete;
    ~HostFilling();

    /// `bytes` bytes, their contents undefined; what has been written can be read.
    void* memory() const { return memory_; }

    /// Hands the filled buffer over. If it is not filled in place, its buffer is leased only now, so fillings that are
    /// given up take no memory of the device. Does not wait: the array is kept until it is copied. Nothing may be
    /// written to the memory any more.
    BufferPool::Lease finish();

private:
    void unmap();

    const Context& context_;
    std::shared_ptr<BufferPool> pool_;
    std::size_t bytes_;
    const char* purpose_;
    BufferPool::Lease buffer_;  // where it is mapped
    void* memory_ = nullptr;
    bool is_mapped_ = false;
    std::unique_ptr<std::byte[]> array_;  // if the buffer is not mapped
};

/// A buffer with these values. Does not wait.
template <class Values>
BufferPool::Lease uploaded(const Context& context, const std::shared_ptr<BufferPool>& pool, const Values& values,
                           const char* purpose) {
    HostFilling filling(context, pool, values.size() * sizeof(values[0]), purpose);
    std::copy(values.begin(), values.end(), static_cast<std::remove_cvref_t<decltype(values[0])>*>(filling.memory()));
    return filling.finish();
}

/// The same of few values, as copied(): from the pool if the device has memory of its own, to which a write does not
/// wait.
template <class Value>
BufferPool::Lease copied(const Context& context, const std::shared_ptr<BufferPool>& pool,
                         const std::vector<Value>& values, const char* purpose) {
    const Context::Capabilities& device = context.capabilities();
    if (device.has_own_memory && !device.is_processor) return uploaded(context, pool, values, purpose);
    return {nullptr, copied(context, values), values.size() * sizeof(Value)};
}

}  // namespace clsdf::device

#include "device/buffer_pool.hpp"

#include "core/large_memory.hpp"
#include "core/lifetime.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

namespace clsdf::device {

namespace {

void CL_CALLBACK end_share(cl_mem, void* share) {
    delete static_cast<std::shared_ptr<const void>*>(share);
}

cl::Buffer large_buffer(const Context& context, std::size_t bytes) {
    try {
        const std::shared_ptr<void> memory(allocate_large_memory(bytes), &free_large_memory);
        return buffer_in(context, memory, bytes, CL_MEM_READ_WRITE);
    } catch (const std::bad_alloc&) {
        throw cl::Error(CL_OUT_OF_HOST_MEMORY, "clCreateBuffer");
    }
}

/// A large buffer of a processor lies on huge pages: kernels read records all over it. On other devices a
/// fill of one byte uses each new buffer at once. Some drivers allocate a buffer at its first use only; so a lack of
/// memory is reported here, not later. Throws Error.
cl::Buffer make_buffer(const Context& context, std::size_t bytes) {
    return guarded([&] {
        const bool is_processor = context.capabilities().is_processor;
        if (is_processor && bytes >= large_memory_bytes) return large_buffer(context, bytes);
        cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE, bytes);
        if (!is_processor) context.queue().enqueueFillBuffer(buffer, cl_uchar{0}, 0, 1);
        return buffer;
    });
}

}  // namespace

cl::Buffer buffer_in(const Context& context, std::shared_ptr<const void> memory, std::size_t bytes,
                     cl_mem_flags access) {
    auto share = std::make_unique<std::shared_ptr<const void>>(std::move(memory));
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): `access` says what the device may do
    cl::Buffer buffer(context.context(), access | CL_MEM_USE_HOST_PTR, bytes, const_cast<void*>(share->get()));
    buffer.setDestructorCallback(end_share, share.get());
    share.release();
    return buffer;
}

// NOLINTNEXTLINE(bugprone-exception-escape): as its class
BufferPool::Lease& BufferPool::Lease::operator=(Lease&& other) noexcept {
    if (this != &other) {
        give_back();
        pool_ = std::move(other.pool_);
        buffer_ = std::move(other.buffer_);
        bytes_ = other.bytes_;
        mapped_ = std::exchange(other.mapped_, nullptr);
    }
    return *this;
}

const void* BufferPool::Lease::on_host() const {
    if (mapped_ == nullptr && bytes_ > 0)
        guarded([&] {
            void* mapped = nullptr;
            pool_->context_->run_blocking([&](cl::Event* ended) {
                mapped =
                    pool_->context_->queue().enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ, 0, bytes_, nullptr, ended);
            });
            mapped_ = mapped;
        });
    return mapped_;
}

// NOLINTNEXTLINE(bugprone-exception-escape): as its class
void BufferPool::Lease::give_back() noexcept {
    if (!pool_) return;
    if (pool_->context_->is_lost()) return keep_for_good(buffer_);
    // The next user enqueues after it.
    if (mapped_ != nullptr)
        clEnqueueUnmapMemObject(pool_->context_->queue()(), buffer_(), mapped_, 0, nullptr, nullptr);
    try {
        const std::scoped_lock lock(pool_->mutex_);
        pool_->leased_bytes_ -= bytes_;
        pool_->free_.push_back({buffer_, bytes_});
    } catch (const std::exception&) {
        // No memory to remember it by.
        pool_->forget(bytes_);
        pool_->context_->arena().keep({buffer_, bytes_});
    }
    buffer_ = {};
}

std::optional<BufferPool::Lease> BufferPool::take_free(std::size_t wanted) {
    const std::scoped_lock lock(mutex_);
    if (const auto best = smallest_fit(free_, wanted); best != free_.end()) {
        std::optional<Lease> lease(std::in_place, shared_from_this(), std::move(best->buffer), best->bytes);
        leased_bytes_ += best->bytes;
        free_.erase(best);
        return lease;
    }
    auto part = guarded([&] { return context_->arena().take(wanted); });
    if (!part) return std::nullopt;
    *all_bytes_ += part->bytes;
    return lease_of(std::move(*part));
}

BufferPool::Lease BufferPool::lease_of(Arena::Part part) {
    Lease lease(shared_from_this(), std::move(part.buffer), part.bytes);
    leased_bytes_ += part.bytes;
    peak_ = std::max(peak_, leased_bytes_ + free_bytes());
    return lease;
}

static constexpr std::size_t least_bytes = 64;  // of a buffer

// Of errors that remain when what is kept has been released.
static constexpr const char* remedy =
    "compute a smaller part of the grid or fewer points at a time, or a narrower band, and release plans";

void BufferPool::check_size(std::size_t bytes, const char* purpose) const {
    const std::size_t largest = context_->capabilities().largest_allocation;
    if (bytes > largest)
        throw Error(ErrorCode::out_of_memory, fmt::format("the {} need {} bytes of device memory in one piece, and the "
                                                          "device allocates at most {}; {}",
                                                          purpose, bytes, largest, remedy));
}

BufferPool::Lease BufferPool::lease(std::size_t bytes, const char* purpose) {
    const std::size_t wanted = std::max(bytes, least_bytes);
    if (auto free = take_free(wanted)) return std::move(*free);
    check_size(wanted, purpose);
    const Context::Capabilities& device = context_->capabilities();
    if (add_block_for(wanted))
        if (auto free = take_free(wanted)) return std::move(*free);
    const std::scoped_lock lock(mutex_);
    const auto reserve = [&] {
        const std::size_t before = all_bytes_->fetch_add(wanted) + context_->arena().free_bytes();
        if (before + wanted <= device.memory) return true;
        forget(wanted);
        return false;
    };
    if (!reserve() && (!release_free() || !reserve()))
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("the {} need {} bytes of device memory, and {} of the device's {} are in use; {}",
                                purpose, wanted, all_bytes_->load(), device.memory, remedy));
    try {
        return lease_of({make_buffer(*context_, wanted), wanted});
    } catch (const Error&) {
        forget(wanted);
        throw;
    }
}

bool BufferPool::add_block_for(std::size_t wanted) {
    Arena& arena = context_->arena();
    const std::size_t bytes = arena.block_for(wanted);
    if (bytes == 0 || *all_bytes_ + arena.free_bytes() + bytes > context_->capabilities().memory) return false;
    try {
        arena.add_block(make_buffer(*context_, bytes), bytes);
        return true;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::out_of_memory) throw;
        return false;  // a buffer of its own may still fit
    }
}

BufferPool::Lease BufferPool::lease_for_list(std::size_t bytes, const char* purpose) {
    if (auto free = take_free(std::max(bytes, least_bytes))) return std::move(*free);
    if (auto longer = lease_if_it_fits(bytes + bytes / 8, purpose)) return std::move(*longer);
    return lease(bytes, purpose);
}

std::optional<BufferPool::Lease> BufferPool::lease_if_it_fits(std::size_t bytes, const char* purpose) {
    try {
        return lease(bytes, purpose);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::out_of_memory) throw;
        return std::nullopt;
    }
}

void BufferPool::trim() {
    const std::scoped_lock lock(mutex_);
    const auto unused = std::ranges::stable_partition(free_, [](const Free& free) { return free.used; });
    give_up(unused);
    for (Free& free : free_) free.used = false;
}

void BufferPool::hand_back() {
    const std::scoped_lock lock(mutex_);
    give_up(free_);
}

void BufferPool::give_up(std::span<Free> buffers) {
    for (Free& free : buffers) {
        forget(free.bytes);
        if (context_->is_lost())
            keep_for_good(free.buffer);
        else
            context_->arena().keep({std::move(free.buffer), free.bytes});
    }
    free_.erase(free_.end() - static_cast<std::ptrdiff_t>(buffers.size()), free_.end());
}

bool BufferPool::release() {
    const std::scoped_lock lock(mutex_);
    return release_free();
}

bool BufferPool::release_free() {
    const bool had_free = !free_.empty();
    give_up(free_);
    return context_->arena().release() > 0 || had_free;
}

std::size_t BufferPool::peak() const {
    const std::scoped_lock lock(mutex_);
    return peak_;
}

void BufferPool::restart_peak() {
    const std::scoped_lock lock(mutex_);
    peak_ = leased_bytes_ + free_bytes();
}

std::size_t BufferPool::free_bytes() const {
    std::size_t bytes = 0;
    for (const Free& free : free_) bytes += free.bytes;
    return bytes;
}

namespace {

void CL_CALLBACK release_array(cl_event, cl_int, void* array) {
    delete[] static_cast<std::byte*>(array);
}

/// Keeps an array until the command that reads it has ended.
void keep_until(const cl::Event& copied, std::unique_ptr<std::byte[]> array) {
    std::byte* const kept = array.release();
    if (clSetEventCallback(copied(), CL_COMPLETE, release_array, kept) == CL_SUCCESS) return;
    copied.wait();  // the array is never released if the driver cannot tell
    delete[] kept;
}

}  // namespace

HostFilling::HostFilling(const Context& context, std::shared_ptr<BufferPool> pool, std::size_t bytes,
                         const char* purpose, bool in_place)
    : context_(context), pool_(std::move(pool)), bytes_(bytes), purpose_(purpose) {
    if (bytes_ > 0 && in_place) {
        buffer_ = pool_->lease(bytes_, purpose_);
        guarded([&] {
            context_.run_blocking([&](cl::Event* ended) {
                memory_ = context_.queue().enqueueMapBuffer(*buffer_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes_,
                                                            nullptr, ended);
            });
        });
        is_mapped_ = true;
    } else {
        pool_->check_size(bytes_, purpose_);
        array_ = std::make_unique_for_overwrite<std::byte[]>(bytes_);
        memory_ = array_.get();
    }
    if (bytes_ >= large_memory_bytes) advise_huge_pages(memory_, bytes_);
}

HostFilling::~HostFilling() {
    try {
        if (is_mapped_) unmap();
    } catch (const std::exception&) {
        // On the way out after another error.
    }
}

BufferPool::Lease HostFilling::finish() {
    if (is_mapped_) {
        guarded([&] { unmap(); });
        return std::move(buffer_);
    }
    BufferPool::Lease buffer = pool_->lease(bytes_, purpose_);
    if (bytes_ == 0) return buffer;
    guarded([&] {
        if (context_.write(context_.queue(), array_.get(), bytes_, *buffer)) return;
        cl::Event copied;
        context_.queue().enqueueWriteBuffer(*buffer, CL_FALSE, 0, bytes_, memory_, nullptr, &copied);
        keep_until(copied, std::move(array_));
        context_.queue().flush();
    });
    return buffer;
}

void HostFilling::unmap() {
    is_mapped_ = false;
    context_.queue().enqueueUnmapMemObject(*buffer_, memory_);
}

}  // namespace clsdf::device

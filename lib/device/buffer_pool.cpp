#include "device/buffer_pool.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::device {

BufferPool::Lease& BufferPool::Lease::operator=(Lease&& other) noexcept {
    if (this != &other) {
        give_back();
        pool_ = std::move(other.pool_);
        buffer_ = std::move(other.buffer_);
        bytes_ = other.bytes_;
    }
    return *this;
}

void BufferPool::Lease::give_back() noexcept {
    if (!pool_) return;
    try {
        const std::scoped_lock lock(pool_->mutex_);
        pool_->free_.push_back({std::move(buffer_), bytes_});
    } catch (const std::exception&) {
        // No memory to remember it by: the buffer is released instead.
    }
    pool_.reset();
}

std::optional<BufferPool::Lease> BufferPool::take_free(std::size_t wanted) {
    const std::scoped_lock lock(mutex_);
    // The smallest that is large enough, and not so large that its memory would be wasted.
    auto best = free_.end();
    for (auto it = free_.begin(); it != free_.end(); ++it)
        if (it->bytes >= wanted && it->bytes <= 2 * wanted + 4096 && (best == free_.end() || it->bytes < best->bytes))
            best = it;
    if (best == free_.end()) return std::nullopt;
    std::optional<Lease> lease(std::in_place, shared_from_this(), std::move(best->buffer), best->bytes);
    free_.erase(best);
    return lease;
}

BufferPool::Lease BufferPool::lease(std::size_t bytes, const char* purpose) {
    const std::size_t wanted = std::max<std::size_t>(bytes, 64);
    if (auto free = take_free(wanted)) return std::move(*free);
    const std::size_t largest = context_->capabilities().largest_allocation;
    if (wanted > largest)
        throw Error(ErrorCode::out_of_memory, fmt::format("the {} need {} bytes of device memory in one piece, and the "
                                                          "device allocates at most {}; compute a smaller "
                                                          "part of the grid at a time, or a narrower band",
                                                          purpose, wanted, largest));
    return guarded(
        [&] { return Lease(shared_from_this(), cl::Buffer(context_->context(), CL_MEM_READ_WRITE, wanted), wanted); });
}

void BufferPool::trim() {
    const std::scoped_lock lock(mutex_);
    std::erase_if(free_, [](const Free& free) { return !free.used; });
    for (Free& free : free_) free.used = false;
}

}  // namespace clsdf::device

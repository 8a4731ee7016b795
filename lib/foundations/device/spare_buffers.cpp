#include "device/spare_buffers.hpp"

#include <exception>
#include <utility>

namespace clsdf::device {

void SpareBuffers::set_limit(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    limit_ = bytes;
}

void SpareBuffers::keep(Spare spare) noexcept {
    try {
        const std::scoped_lock lock(mutex_);
        if (spare.bytes > limit_) return;
        bytes_ += spare.bytes;
        spares_.push_back(std::move(spare));
        auto first_kept = spares_.begin();
        for (; bytes_ > limit_; ++first_kept) bytes_ -= first_kept->bytes;
        spares_.erase(spares_.begin(), first_kept);
    } catch (const std::exception&) {
        // No memory to remember it by: the buffer is released instead.
    }
}

std::optional<SpareBuffers::Spare> SpareBuffers::take(std::size_t wanted) {
    const std::scoped_lock lock(mutex_);
    const auto best = smallest_fit(spares_, wanted);
    if (best == spares_.end()) return std::nullopt;
    std::optional<Spare> taken(std::move(*best));
    spares_.erase(best);
    bytes_ -= taken->bytes;
    return taken;
}

std::size_t SpareBuffers::release() {
    const std::scoped_lock lock(mutex_);
    spares_.clear();
    return std::exchange(bytes_, 0);
}

std::size_t SpareBuffers::bytes() const {
    const std::scoped_lock lock(mutex_);
    return bytes_;
}

}  // namespace clsdf::device

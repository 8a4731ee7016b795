#include "device/pinned_copies.hpp"

#include "core/lifetime.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace clsdf::device {

namespace {

void copy_on_all_cores(const std::byte* from, std::byte* to, std::size_t bytes) {
    constexpr std::size_t chunk = std::size_t{128} << 10;
    for_each_chunk(bytes, chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::memcpy(to + begin, from + begin, end - begin);
    });
}

constexpr std::size_t alignment = 4096;  // of what is copied to pinned memory

bool is_in_use(const cl::Event& used) {
    return used() != nullptr && used.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE;
}

}  // namespace

bool PinnedCopies::make_memory() {
    try {
        if (maps_() == nullptr) maps_ = cl::CommandQueue(context_, device_);
        buffer_ = cl::Buffer(context_, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, 2 * half_bytes);
        memory_ = static_cast<std::byte*>(
            maps_.enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, 2 * half_bytes));
    } catch (const cl::Error&) {
        return false;
    }
    return true;
}

bool PinnedCopies::has_memory(Half& half) {
    if (half.memory != nullptr) return true;
    const std::scoped_lock lock(mutex_);
    if (memory_ == nullptr && !make_memory()) return false;
    half.memory = &half == &reads_ ? memory_ : memory_ + half_bytes;
    return true;
}

std::size_t PinnedCopies::release() noexcept {
    const std::scoped_lock lock(reads_.mutex, writes_.mutex, mutex_);
    for (const Use& use : uses_) clWaitForEvents(1, &use.written());
    uses_.clear();
    reads_.memory = writes_.memory = nullptr;
    if (memory_ == nullptr) return 0;
    clEnqueueUnmapMemObject(maps_(), buffer_(), memory_, 0, nullptr, nullptr);
    clFinish(maps_());
    memory_ = nullptr;
    buffer_ = {};
    return 2 * half_bytes;
}

std::size_t PinnedCopies::bytes() const {
    const std::scoped_lock lock(mutex_);
    return memory_ == nullptr ? 0 : 2 * half_bytes;
}

void PinnedCopies::give_up(Half& half, const cl::CommandQueue& queue) {
    const bool has_ended = clFinish(queue()) == CL_SUCCESS;
    if (&half == &writes_) uses_.clear();
    if (has_ended) return;
    half.memory = nullptr;
    // The other half stays in use.
    const std::scoped_lock lock(mutex_);
    keep_for_good(buffer_);
    buffer_ = {};
    memory_ = nullptr;
}

void PinnedCopies::read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t bytes, std::byte* to) {
    const std::scoped_lock lock(reads_.mutex);
    if (bytes <= least_bytes || !has_memory(reads_)) {
        queue.enqueueReadBuffer(from, CL_TRUE, 0, bytes, to);
        return;
    }
    const std::size_t count = chunk_count(bytes, piece_bytes);
    const auto length = [&](std::size_t n) { return std::min(piece_bytes, bytes - n * piece_bytes); };
    const auto memory = [&](std::size_t n) { return reads_.memory + n % pieces_at_once * piece_bytes; };
    std::array<cl::Event, pieces_at_once> under_way;
    const auto start = [&](std::size_t n) {
        queue.enqueueReadBuffer(from, CL_FALSE, n * piece_bytes, length(n), memory(n), nullptr,
                                &under_way[n % pieces_at_once]);
        queue.flush();
    };
    try {
        for (std::size_t n = 0; n < std::min(count, pieces_at_once); ++n) start(n);
        for (std::size_t n = 0; n < count; ++n) {
            under_way[n % pieces_at_once].wait();
            copy_on_all_cores(memory(n), to + n * piece_bytes, length(n));
            if (n + pieces_at_once < count) start(n + pieces_at_once);
        }
    } catch (...) {
        give_up(reads_, queue);
        throw;
    }
}

bool PinnedCopies::write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes,
                         const cl::Buffer& to) {
    const std::scoped_lock lock(writes_.mutex);
    if (bytes <= least_bytes || !has_memory(writes_)) return false;
    std::erase_if(uses_, [](const Use& use) { return !is_in_use(use.written); });
    try {
        for (std::size_t begin = 0; begin < bytes; begin += piece_bytes) {
            const std::size_t length = std::min(piece_bytes, bytes - begin);
            if (next_ + length > half_bytes) next_ = 0;
            const auto overlaps = [&](const Use& use) { return use.begin < next_ + length && next_ < use.end; };
            // Small arrays do not wait for memory: the driver copies them as quickly.
            if (bytes <= piece_bytes && std::ranges::any_of(uses_, overlaps)) return false;
            for (const Use& use : uses_)
                if (overlaps(use)) use.written.wait();
            std::erase_if(uses_, overlaps);
            copy_on_all_cores(from + begin, writes_.memory + next_, length);
            uses_.push_back({next_, next_ + length, {}});
            queue.enqueueWriteBuffer(to, CL_FALSE, begin, length, writes_.memory + next_, nullptr,
                                     &uses_.back().written);
            next_ = chunk_count(next_ + length, alignment) * alignment;
            queue.flush();
        }
    } catch (...) {
        give_up(writes_, queue);
        throw;
    }
    return true;
}

}  // namespace clsdf::device

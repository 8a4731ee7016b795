#include "device/pinned_copies.hpp"

#include "core/lifetime.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <exception>
#include <functional>
#include <optional>
#include <thread>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace clsdf::device {

namespace {

void copy_on_all_cores(const std::byte* from, std::byte* to, std::size_t bytes) {
    constexpr std::size_t chunk = std::size_t{128} << 10;
    for_each_chunk(bytes, chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::memcpy(to + begin, from + begin, end - begin);
    });
}

constexpr std::size_t alignment = 4096;  // of what is copied to pinned memory

/// Of room: whole lines of a cache, at least one.
std::size_t in_lines(std::size_t bytes) {
    constexpr std::size_t line = 64;
    return std::max<std::size_t>(chunk_count(bytes, line), 1) * line;
}

/// Copies without reading the cache lines that it writes.
void copy_streaming(const std::byte* from, std::byte* to, std::size_t bytes) {
#ifdef __SSE2__
    const std::size_t head = std::min(bytes, (16 - reinterpret_cast<std::uintptr_t>(to) % 16) % 16);
    std::memcpy(to, from, head);
    std::size_t i = head;
    for (; i + 64 <= bytes; i += 64)
        for (std::size_t j = i; j < i + 64; j += 16)
            _mm_stream_si128(reinterpret_cast<__m128i*>(to + j),
                             _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + j)));
    _mm_sfence();
    std::memcpy(to + i, from + i, bytes - i);
#else
    std::memcpy(to, from, bytes);
#endif
}

// A core copies about 10 GB a second, and links to GPUs have 60.
constexpr std::size_t most_helpers = 7;
constexpr std::size_t bytes_of_a_helper = std::size_t{1} << 20;

constexpr std::size_t chunk_bytes = std::size_t{128} << 10;
constexpr std::size_t chunks_of_piece = PinnedCopies::piece_bytes / chunk_bytes;
static_assert(PinnedCopies::piece_bytes % chunk_bytes == 0);

/// Copies, by several threads, of pieces that arrive in order in a ring. One thread tells which have arrived.
class RingCopies {
public:
    RingCopies(const std::byte* ring, std::byte* to, std::size_t bytes) : ring_(ring), to_(to), bytes_(bytes) {}

    /// The next piece has arrived.
    void arrive() { arrived_ = std::min(arrived_ + chunks_of_piece, chunks_); }
    /// Copies the next chunk of what has arrived; false if there is none.
    bool copy_next() {
        std::size_t chunk = next_;
        do
            if (chunk >= arrived_) return false;
        while (!next_.compare_exchange_weak(chunk, chunk + 1));
        const std::size_t begin = chunk * chunk_bytes;
        copy_streaming(ring_ + begin % (PinnedCopies::pieces_at_once * PinnedCopies::piece_bytes), to_ + begin,
                       std::min(chunk_bytes, bytes_ - begin));
        ++copied_[chunk / chunks_of_piece % PinnedCopies::pieces_at_once];
        return true;
    }
    /// Returns when the last chunk of the pieces before `end` is copied, or begun by another thread, or after stop().
    void help(std::size_t end) {
        const std::size_t last = std::min(end * chunks_of_piece, chunks_);
        while (!stopped_ && next_ < last)
            if (!copy_next()) std::this_thread::yield();
    }
    void stop() { stopped_ = true; }

    bool is_copied(std::size_t piece) const {
        const std::size_t before = piece / PinnedCopies::pieces_at_once * chunks_of_piece;  // in the same place
        return copied_[piece % PinnedCopies::pieces_at_once] ==
               before + std::min(chunks_of_piece, chunks_ - piece * chunks_of_piece);
    }

private:
    const std::byte* ring_;
    std::byte* to_;
    std::size_t bytes_;
    std::size_t chunks_ = chunk_count(bytes_, chunk_bytes);
    std::atomic<std::size_t> arrived_ = 0, next_ = 0;                              // in chunks
    std::array<std::atomic<std::size_t>, PinnedCopies::pieces_at_once> copied_{};  // of each place in the ring
    std::atomic<bool> stopped_ = false;
};

}  // namespace

/// With mutex_ locked.
const cl::CommandQueue& PinnedCopies::made_queue() {
    if (queue_() == nullptr) queue_ = cl::CommandQueue(context_, device_);
    return queue_;
}

cl::CommandQueue PinnedCopies::queue() {
    const std::scoped_lock lock(mutex_);
    return made_queue();
}

bool PinnedCopies::make_memory() {
    try {
        buffer_ = cl::Buffer(context_, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, all_bytes);
        memory_ = static_cast<std::byte*>(
            made_queue().enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, all_bytes));
        has_failed_ = false;
    } catch (const cl::Error&) {
        buffer_ = {};
        has_failed_ = true;
    }
    return !has_failed_;
}

PinnedCopies::~PinnedCopies() {
    release();
    if (memory_ != nullptr) keep_for_good(buffer_);  // commands may still write to room that is taken
}

bool PinnedCopies::has_memory(Part& part) {
    if (part.memory != nullptr) return true;
    const std::scoped_lock lock(mutex_);
    if (memory_ == nullptr && !make_memory()) return false;
    part.memory = &part == &reads_ ? memory_ : memory_ + read_bytes;
    return true;
}

std::byte* PinnedCopies::take_room(std::size_t bytes) noexcept {
    try {
        const std::scoped_lock lock(mutex_);
        if (memory_ == nullptr && (has_failed_ || !make_memory())) return nullptr;
        const std::optional<std::size_t> offset = free_room_.take(in_lines(bytes));
        return offset ? room() + *offset : nullptr;
    } catch (const std::exception&) {
        return nullptr;
    }
}

void PinnedCopies::give_back_room(std::byte* room_taken, std::size_t bytes) noexcept {
    const std::scoped_lock lock(mutex_);
    const std::less<const std::byte*> is_before;
    // After an error the memory may be another one.
    if (memory_ == nullptr || is_before(room_taken, room()) || !is_before(room_taken, room() + room_bytes)) return;
    try {
        free_room_.give_back(static_cast<std::size_t>(room_taken - room()), in_lines(bytes));
    } catch (const std::exception&) {
        // No memory to remember it by: it is not taken again.
    }
}

std::size_t PinnedCopies::release() noexcept {
    const std::scoped_lock lock(reads_.mutex, writes_.mutex, mutex_);
    if (!free_room_.are_all_free()) return 0;
    for (const Use& use : uses_) clWaitForEvents(1, &use.written());
    uses_.clear();
    reads_.memory = writes_.memory = nullptr;
    has_failed_ = false;
    if (memory_ == nullptr) return 0;
    clEnqueueUnmapMemObject(queue_(), buffer_(), memory_, 0, nullptr, nullptr);
    clFinish(queue_());
    memory_ = nullptr;
    buffer_ = {};
    return all_bytes;
}

std::size_t PinnedCopies::bytes() const {
    const std::scoped_lock lock(mutex_);
    return memory_ == nullptr ? 0 : all_bytes;
}

void PinnedCopies::give_up(Part& part, const cl::CommandQueue& queue) {
    const bool has_ended = clFinish(queue()) == CL_SUCCESS;
    if (&part == &writes_) uses_.clear();
    if (has_ended) return;
    part.memory = nullptr;
    // The other part stays in use.
    const std::scoped_lock lock(mutex_);
    keep_for_good(buffer_);
    buffer_ = {};
    memory_ = nullptr;
    free_room_ = FreeRanges(room_bytes);
}

void PinnedCopies::read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
                        std::byte* to, std::span<const Milestone> milestones) {
    const std::scoped_lock lock(reads_.mutex);
    if (bytes <= least_bytes || !has_memory(reads_)) {
        read_blocking(queue, from, begin, bytes, to, milestones.empty() ? cl::Event() : milestones.back().reached);
        return;
    }
    const std::size_t count = chunk_count(bytes, piece_bytes);
    std::array<cl::Event, pieces_at_once> under_way;
    std::vector<cl::Event> wait_list(milestones.empty() ? 0 : 1);
    const auto start = [&](std::size_t n) {
        const std::size_t first = n * piece_bytes, length = std::min(piece_bytes, bytes - first);
        if (!milestones.empty())
            wait_list[0] = std::ranges::lower_bound(milestones, first + length, {}, &Milestone::end)->reached;
        queue.enqueueReadBuffer(from, CL_FALSE, begin + first, length, reads_.memory + n % pieces_at_once * piece_bytes,
                                milestones.empty() ? nullptr : &wait_list, &under_way[n % pieces_at_once]);
        queue.flush();
    };
    RingCopies copies(reads_.memory, to, bytes);
    std::size_t started = 0, arrived = 0, copied = 0;
    const auto start_some = [&] {
        while (started < std::min(count, copied + pieces_at_once)) start(started++);
    };
    const auto wait_for_next = [&] {
        wait_until_ended(under_way[arrived % pieces_at_once]);
        copies.arrive();
        ++arrived;
    };
    const auto copy_until = [&](std::size_t end) {
        while (copied < end) {
            start_some();
            if (copied < arrived && copies.is_copied(copied))
                ++copied;
            else if (arrived < std::min(end, started) &&
                     (copied == arrived || has_ended(under_way[arrived % pieces_at_once])))
                wait_for_next();
            else if (!copies.copy_next())
                std::this_thread::yield();
        }
    };
    // Pieces that are complete together; while the device computes, no thread must poll.
    const auto copy_together = [&](std::size_t end) {
        if (copied >= end) return;
        start_some();
        wait_for_next();
        // Helpers for all pieces: to wake threads for each takes as long as the device takes to send one.
        with_helpers(
            std::min(most_helpers, (end - copied) * piece_bytes / bytes_of_a_helper), [&] { copies.help(end); },
            [&] {
                try {
                    copy_until(end);
                } catch (...) {
                    copies.stop();
                    throw;
                }
            });
    };
    try {
        for (const Milestone& milestone : milestones) copy_together(milestone.end / piece_bytes);
        copy_together(count);
    } catch (...) {
        give_up(reads_, queue);
        throw;
    }
}

bool PinnedCopies::write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes,
                         const cl::Buffer& to) {
    const std::scoped_lock lock(writes_.mutex);
    if (bytes <= least_bytes || !has_memory(writes_)) return false;
    std::erase_if(uses_, [](const Use& use) { return has_ended(use.written); });
    try {
        for (std::size_t begin = 0; begin < bytes; begin += piece_bytes) {
            const std::size_t length = std::min(piece_bytes, bytes - begin);
            if (next_ + length > written_bytes) next_ = 0;
            const auto overlaps = [&](const Use& use) { return use.begin < next_ + length && next_ < use.end; };
            // Small arrays do not wait for memory: the driver copies them as quickly.
            if (bytes <= piece_bytes && std::ranges::any_of(uses_, overlaps)) return false;
            for (const Use& use : uses_)
                if (overlaps(use)) wait_until_ended(use.written);
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

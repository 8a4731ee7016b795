#include "device/pinned_copies.hpp"

#include "core/lifetime.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <cstring>

namespace clsdf::device {

namespace {

void copy_on_all_cores(const std::byte* from, std::byte* to, std::size_t bytes) {
    constexpr std::size_t chunk = std::size_t{128} << 10;
    for_each_chunk(bytes, chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::memcpy(to + begin, from + begin, end - begin);
    });
}

bool is_in_use(const cl::Event& used) {
    return used() != nullptr && used.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE;
}

}  // namespace

PinnedCopies::~PinnedCopies() {
    for (const Piece& piece : pieces_) {
        if (piece.memory == nullptr) continue;
        if (piece.used() != nullptr) clWaitForEvents(1, &piece.used());
        clEnqueueUnmapMemObject(maps_(), piece.buffer(), piece.memory, 0, nullptr, nullptr);
    }
    if (maps_() != nullptr) clFinish(maps_());
}

bool PinnedCopies::make_pieces() {
    if (pieces_.back().memory != nullptr) return true;
    try {
        if (maps_() == nullptr) maps_ = cl::CommandQueue(context_, device_);
        for (Piece& piece : pieces_) {
            if (piece.memory != nullptr) continue;
            piece.buffer = cl::Buffer(context_, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, piece_bytes);
            piece.memory = static_cast<std::byte*>(
                maps_.enqueueMapBuffer(piece.buffer, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, piece_bytes));
        }
    } catch (const cl::Error&) {
        return false;
    }
    return true;
}

PinnedCopies::Piece& PinnedCopies::free_piece() {
    Piece& piece = pieces_[next_++ % pieces_.size()];
    const cl::Event used = piece.used;
    piece.used = cl::Event();
    if (is_in_use(used)) used.wait();
    return piece;
}

void PinnedCopies::give_up(const cl::CommandQueue& queue) {
    if (clFinish(queue()) != CL_SUCCESS) keep_for_good(pieces_);
    pieces_ = {};
}

void PinnedCopies::read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t bytes, std::byte* to) {
    const std::scoped_lock lock(mutex_);
    if (bytes <= least_bytes || !make_pieces()) {
        queue.enqueueReadBuffer(from, CL_TRUE, 0, bytes, to);
        return;
    }
    const std::size_t count = chunk_count(bytes, piece_bytes);
    const auto length = [&](std::size_t n) { return std::min(piece_bytes, bytes - n * piece_bytes); };
    std::array<Piece*, std::tuple_size_v<decltype(pieces_)>> under_way{};
    const auto start = [&](std::size_t n) {
        Piece& piece = free_piece();
        under_way[n % under_way.size()] = &piece;
        queue.enqueueReadBuffer(from, CL_FALSE, n * piece_bytes, length(n), piece.memory, nullptr, &piece.used);
        queue.flush();
    };
    try {
        for (std::size_t n = 0; n < std::min(count, under_way.size()); ++n) start(n);
        for (std::size_t n = 0; n < count; ++n) {
            Piece& piece = *under_way[n % under_way.size()];
            piece.used.wait();
            piece.used = cl::Event();
            copy_on_all_cores(piece.memory, to + n * piece_bytes, length(n));
            if (n + under_way.size() < count) start(n + under_way.size());
        }
    } catch (...) {
        give_up(queue);
        throw;
    }
}

bool PinnedCopies::write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes,
                         const cl::Buffer& to) {
    const std::scoped_lock lock(mutex_);
    if (bytes <= least_bytes || !make_pieces()) return false;
    // Small arrays do not wait for a piece: the driver copies them as quickly.
    if (bytes <= piece_bytes && is_in_use(pieces_[next_ % pieces_.size()].used)) return false;
    try {
        for (std::size_t begin = 0; begin < bytes; begin += piece_bytes) {
            const std::size_t length = std::min(piece_bytes, bytes - begin);
            Piece& piece = free_piece();
            copy_on_all_cores(from + begin, piece.memory, length);
            queue.enqueueWriteBuffer(to, CL_FALSE, begin, length, piece.memory, nullptr, &piece.used);
            queue.flush();
        }
    } catch (...) {
        give_up(queue);
        throw;
    }
    return true;
}

}  // namespace clsdf::device

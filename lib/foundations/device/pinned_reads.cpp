#include "device/pinned_reads.hpp"

#include "core/lifetime.hpp"
#include "core/parallel.hpp"

#include <cstring>

namespace clsdf::device {

namespace {

void copy_on_all_cores(const void* from, std::byte* to, std::size_t bytes) {
    constexpr std::size_t chunk = std::size_t{128} << 10;
    for_each_chunk(bytes, chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::memcpy(to + begin, static_cast<const std::byte*>(from) + begin, end - begin);
    });
}

}  // namespace

PinnedReads::~PinnedReads() {
    for (const Piece& piece : pieces_)
        if (piece.memory != nullptr)
            clEnqueueUnmapMemObject(maps_(), piece.buffer(), piece.memory, 0, nullptr, nullptr);
    if (maps_() != nullptr) clFinish(maps_());
}

bool PinnedReads::make_pieces() {
    if (pieces_.back().memory != nullptr) return true;
    try {
        if (maps_() == nullptr) maps_ = cl::CommandQueue(context_, device_);
        for (Piece& piece : pieces_) {
            if (piece.memory != nullptr) continue;
            piece.buffer = cl::Buffer(context_, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, piece_bytes);
            piece.mapped.resize(1);
            piece.memory = maps_.enqueueMapBuffer(piece.buffer, CL_FALSE, CL_MAP_WRITE_INVALIDATE_REGION, 0,
                                                  piece_bytes, nullptr, piece.mapped.data());
        }
        maps_.flush();
    } catch (const cl::Error&) {
        return false;
    }
    return true;
}

void PinnedReads::read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t bytes, std::byte* to) {
    const std::scoped_lock lock(mutex_);
    if (bytes <= piece_bytes || !make_pieces()) {
        queue.enqueueReadBuffer(from, CL_TRUE, 0, bytes, to);
        return;
    }
    const std::size_t count = chunk_count(bytes, piece_bytes);
    const auto length = [&](std::size_t n) { return std::min(piece_bytes, bytes - n * piece_bytes); };
    const auto start = [&](std::size_t n) {
        Piece& piece = pieces_[n % pieces_.size()];
        queue.enqueueReadBuffer(from, CL_FALSE, n * piece_bytes, length(n), piece.memory, &piece.mapped, &piece.read);
        queue.flush();
    };
    try {
        for (std::size_t n = 0; n < std::min(count, pieces_.size()); ++n) start(n);
        for (std::size_t n = 0; n < count; ++n) {
            const Piece& piece = pieces_[n % pieces_.size()];
            piece.read.wait();
            copy_on_all_cores(piece.memory, to + n * piece_bytes, length(n));
            if (n + pieces_.size() < count) start(n + pieces_.size());
        }
    } catch (...) {
        // Commands that are still running write to the pieces.
        if (clFinish(queue()) != CL_SUCCESS) {
            keep_for_good(pieces_);
            pieces_ = {};
        }
        throw;
    }
}

}  // namespace clsdf::device

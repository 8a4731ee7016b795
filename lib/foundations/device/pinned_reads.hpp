#pragma once

#include "device/opencl.hpp"

#include <array>
#include <cstddef>
#include <mutex>
#include <vector>

namespace clsdf::device {

/// Copies the memory of a device to the host's. A driver copies slowly to memory that is not pinned. So pieces are read
/// into pinned memory, and all cores copy one from there while the device sends the next ones. The pinned memory is
/// made at the first large read and kept.
class PinnedReads {
public:
    PinnedReads(cl::Context context, cl::Device device) : context_(std::move(context)), device_(std::move(device)) {}
    ~PinnedReads();
    PinnedReads(const PinnedReads&) = delete;
    PinnedReads& operator=(const PinnedReads&) = delete;

    /// Returns when `to` holds the first `bytes` bytes of `from`; what computes them must have ended. Without pinned
    /// memory, and for a few bytes, the driver copies. From several threads one reads after the other. Throws
    /// cl::Error.
    void read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t bytes, std::byte* to);

    static constexpr std::size_t piece_bytes = std::size_t{2} << 20;

private:
    struct Piece {
        cl::Buffer buffer;
        void* memory = nullptr;
        std::vector<cl::Event> mapped;  ///< one: the memory may be written
        cl::Event read;
    };

    bool make_pieces();

    cl::Context context_;
    cl::Device device_;
    std::mutex mutex_;
    cl::CommandQueue maps_;
    std::array<Piece, 3> pieces_;
};

}  // namespace clsdf::device

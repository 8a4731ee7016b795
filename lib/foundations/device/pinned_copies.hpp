#pragma once

#include "device/opencl.hpp"

#include <array>
#include <cstddef>
#include <mutex>
#include <vector>

namespace clsdf::device {

/// Copies between the memory of a device and the host's. A driver copies slowly from and to memory that is not pinned.
/// So bytes pass through pieces of pinned memory: all cores copy one piece while the device sends others. The pieces
/// are made at the first large copy and kept. Copies of several threads take turns.
class PinnedCopies {
public:
    PinnedCopies(cl::Context context, cl::Device device) : context_(std::move(context)), device_(std::move(device)) {}
    ~PinnedCopies();
    PinnedCopies(const PinnedCopies&) = delete;
    PinnedCopies& operator=(const PinnedCopies&) = delete;

    /// Returns when `to` holds the first `bytes` bytes of `from`; what computes them has ended, or is before it in the
    /// queue. Without pinned memory, and for a few bytes, the driver copies. Throws cl::Error.
    void read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t bytes, std::byte* to);

    /// Enqueues copies to the first `bytes` bytes of `to`, and returns when `from` is not needed any more. Returns
    /// false, and has done nothing, without pinned memory and for a few bytes. Throws cl::Error.
    bool write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes, const cl::Buffer& to);

    static constexpr std::size_t piece_bytes = std::size_t{2} << 20;
    /// Drivers copy fewer bytes at once, without a transfer of their own.
    static constexpr std::size_t least_bytes = std::size_t{32} << 10;

private:
    struct Piece {
        cl::Buffer buffer;
        std::byte* memory = nullptr;
        cl::Event used;  ///< the last command on the memory, which may still run
    };

    bool make_pieces();
    /// The piece that was used longest ago, which no command uses any more.
    Piece& free_piece();
    /// After an error: commands that are still running use the pieces.
    void give_up(const cl::CommandQueue& queue);

    cl::Context context_;
    cl::Device device_;
    std::mutex mutex_;
    cl::CommandQueue maps_;
    std::array<Piece, 4> pieces_;
    std::size_t next_ = 0;
};

}  // namespace clsdf::device

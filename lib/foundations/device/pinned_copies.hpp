#pragma once

#include "device/opencl.hpp"

#include <cstddef>
#include <mutex>
#include <vector>

namespace clsdf::device {

/// Copies between the memory of a device and the host's. A driver copies slowly from and to memory that is not pinned.
/// So bytes pass through pieces of pinned memory: all cores copy one piece while the device sends others. The memory is
/// made at the first copy and kept, a half for each direction. Copies of one direction and several threads take turns.
class PinnedCopies {
public:
    PinnedCopies(cl::Context context, cl::Device device) : context_(std::move(context)), device_(std::move(device)) {}
    ~PinnedCopies() { release(); }
    PinnedCopies(const PinnedCopies&) = delete;
    PinnedCopies& operator=(const PinnedCopies&) = delete;

    /// Returns when `to` holds `bytes` bytes of `from`, from byte `begin` on; what computes them is before it in the
    /// queue, or has ended when the events have. Without pinned memory, and for a few bytes, the driver copies. Throws
    /// cl::Error.
    void read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
              std::byte* to, const std::vector<cl::Event>& events);

    /// Enqueues copies to the first `bytes` bytes of `to`, and returns when `from` is not needed any more. Returns
    /// false, and has done nothing, without pinned memory and for a few bytes. Throws cl::Error.
    bool write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes, const cl::Buffer& to);

    /// A queue of its own, made at the first call: for copies while the device computes. Throws cl::Error.
    cl::CommandQueue queue();

    /// Waits for copies that are under way, and releases the memory; the next copy makes it anew. Returns its bytes.
    std::size_t release() noexcept;
    /// Bytes of the memory.
    std::size_t bytes() const;

    static constexpr std::size_t piece_bytes = std::size_t{2} << 20;
    /// Drivers copy fewer bytes at once, without a transfer of their own.
    static constexpr std::size_t least_bytes = std::size_t{32} << 10;
    static constexpr std::size_t pieces_at_once = 4;

private:
    static constexpr std::size_t half_bytes = pieces_at_once * piece_bytes;

    /// The memory of one direction.
    struct Half {
        std::mutex mutex;
        std::byte* memory = nullptr;
    };
    /// A part of the memory from which a command writes, which may still run.
    struct Use {
        std::size_t begin, end;
        cl::Event written;
    };

    const cl::CommandQueue& made_queue();
    bool make_memory();
    /// Whether the half, whose mutex is locked, has pinned memory.
    bool has_memory(Half& half);
    /// After an error: commands that are still running use the half.
    void give_up(Half& half, const cl::CommandQueue& queue);

    cl::Context context_;
    cl::Device device_;
    Half reads_, writes_;
    std::vector<Use> uses_;     // of writes_; its mutex guards both
    std::size_t next_ = 0;      // where the next piece of a write begins
    mutable std::mutex mutex_;  // for what follows; locked after a half's
    cl::CommandQueue queue_;
    cl::Buffer buffer_;
    std::byte* memory_ = nullptr;
};

}  // namespace clsdf::device

#pragma once

#include "device/free_ranges.hpp"
#include "device/opencl.hpp"

#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

namespace clsdf::device {

/// Bytes below `end` of what is read are complete when the event has ended.
struct Milestone {
    std::size_t end;
    cl::Event reached;
};

/// Copies between the memory of a device and the host's. A driver copies slowly from and to memory that is not pinned.
/// So bytes pass through pieces of pinned memory: all cores copy one piece while the device sends others. The memory is
/// made at the first copy and kept, a part for each direction. Copies of one direction and several threads take turns.
/// Behind these parts is room for a few values that commands read (ReadBack).
class PinnedCopies {
public:
    PinnedCopies(cl::Context context, cl::Device device) : context_(std::move(context)), device_(std::move(device)) {}
    ~PinnedCopies();
    PinnedCopies(const PinnedCopies&) = delete;
    PinnedCopies& operator=(const PinnedCopies&) = delete;

    /// Returns when `to` holds `bytes` bytes of `from`, from byte `begin` on. They are complete when the commands
    /// before it in the queue have ended or, if there are milestones, when these are reached: their ends ascend and
    /// count from `begin`, and the last one is `bytes`. Without pinned memory, and for a few bytes, the driver copies.
    /// Throws CommandError if a command before it has failed, and cl::Error.
    void read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
              std::byte* to, std::span<const Milestone> milestones);

    /// Enqueues copies to the first `bytes` bytes of `to`, and returns when `from` is not needed any more. Returns
    /// false, and has done nothing, without pinned memory and for a few bytes. Throws cl::Error.
    bool write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes, const cl::Buffer& to);

    /// Pinned memory for a few values, aligned for any of them; null without pinned memory, and if there is no room.
    std::byte* take_room(std::size_t bytes) noexcept;
    void give_back_room(std::byte* room, std::size_t bytes) noexcept;

    /// A queue of its own, made at the first call: for copies while the device computes. Throws cl::Error.
    cl::CommandQueue queue();

    /// Waits for copies that are under way, and releases the memory, unless room in it is taken; the next copy makes it
    /// anew. Returns its bytes.
    std::size_t release() noexcept;
    /// Bytes of the memory.
    std::size_t bytes() const;

    static constexpr std::size_t piece_bytes = std::size_t{2} << 20;
    /// Drivers copy fewer bytes at once, without a transfer of their own.
    static constexpr std::size_t least_bytes = std::size_t{32} << 10;
    /// Pieces of a read that are under way or wait for the host's copies. With four the device waits for the host.
    static constexpr std::size_t pieces_at_once = 16;

private:
    static constexpr std::size_t read_bytes = pieces_at_once * piece_bytes, written_bytes = 4 * piece_bytes;
    static constexpr std::size_t room_bytes = std::size_t{256} << 10;
    static constexpr std::size_t all_bytes = read_bytes + written_bytes + room_bytes;

    /// The memory of one direction.
    struct Part {
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
    std::byte* room() const { return memory_ + read_bytes + written_bytes; }
    /// Whether the part, whose mutex is locked, has pinned memory.
    bool has_memory(Part& part);
    /// After an error: commands that are still running use the part.
    void give_up(Part& part, const cl::CommandQueue& queue);

    cl::Context context_;
    cl::Device device_;
    Part reads_, writes_;
    std::vector<Use> uses_;     // of writes_; its mutex guards both
    std::size_t next_ = 0;      // where the next piece of a write begins
    mutable std::mutex mutex_;  // for what follows; locked after a part's
    cl::CommandQueue queue_;
    cl::Buffer buffer_;
    std::byte* memory_ = nullptr;
    bool has_failed_ = false;  // to make the memory
    FreeRanges free_room_{room_bytes};
};

}  // namespace clsdf::device

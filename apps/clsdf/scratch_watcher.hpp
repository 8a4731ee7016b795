#pragma once

#include "scratch_blocks.hpp"

#include "core/files.hpp"

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>

/// A thread that keeps the resident memory of the process within a limit, as far as pages of ScratchBlocks can leave
/// the memory. Pages leave in two steps, so that those in use come back before they are gone: pieces of all blocks are
/// unmapped in turn, and begin their way to disk; a queue later, what was not used again leaves the memory.
class ScratchWatcher {
public:
    explicit ScratchWatcher(std::size_t limit);
    ~ScratchWatcher();
    ScratchWatcher(const ScratchWatcher&) = delete;
    ScratchWatcher& operator=(const ScratchWatcher&) = delete;

    /// Resident pages of the process, and those of the queue.
    std::size_t most_resident() const { return most_resident_; }
    /// Seconds for which the other threads were stopped, as the disk was slower than they were.
    double stopped_seconds() const { return stopped_seconds_; }

private:
    void run();
    bool keep_within_limit();
    std::size_t total();
    /// Unmaps a piece, or lets one leave the memory; false if there is nothing to do. Its caller has the mutex.
    bool free_some();
    bool free_with_all_stopped();

    static constexpr std::size_t longest_queue = 4096;

    std::size_t low_, high_;  // beyond the second, pages leave until the first is reached
    std::size_t stopping_;    // beyond it, all threads wait
    std::size_t most_queued_;
    clsdf::Descriptor statm_;
    struct Queued {
        ScratchBlocks::Piece piece;
        std::size_t resident = 0;  ///< bytes
    };
    std::array<Queued, longest_queue> queue_{};
    std::size_t first_ = 0, length_ = 0, queued_ = 0;  // queued_: bytes
    bool is_futile_ = false;                           // what is beyond the limit cannot leave the memory
    std::atomic<std::size_t> most_resident_ = 0;
    std::atomic<double> stopped_seconds_ = 0;
    std::mutex mutex_;
    std::condition_variable over_;
    bool is_over_ = false;
    std::thread thread_;
};

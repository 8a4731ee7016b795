#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>

/// The blocks of ScratchMemory: mappings of files without names. Nothing here allocates: operator new calls it.
class ScratchBlocks {
public:
    /// Those of operator new.
    static ScratchBlocks& of_process();

    /// New blocks of so many bytes and more lie in this folder from now on. The descriptor must stay open until
    /// close_folder().
    void open_folder(int folder, std::size_t least_block);
    void close_folder();

    bool is_empty() const { return count_ == 0; }
    bool takes(std::size_t bytes) const { return bytes >= least_block_.load(std::memory_order_relaxed); }
    /// A block, or null. is_full: whether the folder had no room; else there are too many blocks or files.
    void* add(std::size_t bytes, std::size_t alignment, bool& is_full) noexcept;
    /// Whether this was a block; then it is gone.
    bool remove(void* memory) noexcept {
        return count_.load(std::memory_order_relaxed) > 0 &&
               reinterpret_cast<std::uintptr_t>(memory) % smallest_page == 0 && remove_block(memory);
    }
    /// Whether the address is one of a block. Takes no lock: for signal handlers.
    bool contains(const void* address) const;

    struct Failure {
        int error = 0;          ///< the system's number; 0: none
        std::size_t bytes = 0;  ///< of the block
        std::size_t used = 0;   ///< of all others then
    };
    Failure failure() const;
    std::size_t most_bytes() const { return most_bytes_; }
    std::size_t made() const { return made_; }
    /// Bytes that are not in files, because there were too many blocks or files: of all together.
    std::size_t missed() const { return missed_; }

    /// A piece of a block whose pages leave the memory together. It has whole large pages of the system's cache, which
    /// would stay otherwise.
    struct Piece {
        std::size_t slot = 0;
        std::uint32_t serial = 0;  ///< of the block: slots are used again
        std::size_t offset = 0;    ///< in bytes
        std::size_t bytes = 0;
    };
    static constexpr std::size_t piece_bytes = std::size_t{2} << 20;

    // For one thread, which holds the mutex.

    std::mutex& mutex() { return mutex_; }
    std::size_t piece_count() const { return used_ / piece_bytes + count_; }
    /// The next piece with pages in memory, and their bytes, after the one that it gave last; false after a round
    /// without one. Its pages are not mapped any more: the next use of one is a page fault. They are on their way to
    /// disk.
    bool unmap_next(Piece& piece, std::size_t& resident);
    /// Those of its pages that nothing has used since leave the memory. Waits for the disk.
    void evict(const Piece& piece);

private:
    static constexpr std::uintptr_t smallest_page = 4096;
    static constexpr std::size_t most_blocks = 1024;

    struct Block {
        std::byte* address = nullptr;  ///< null: the slot is free
        std::size_t bytes = 0;
        int file = 0;
        std::uint32_t serial = 0;
    };

    bool remove_block(void* memory) noexcept;
    bool put(const Block& block);

    std::atomic<std::size_t> least_block_ = SIZE_MAX;
    std::atomic<std::size_t> count_ = 0;
    mutable std::mutex mutex_;
    int folder_ = -1;
    std::array<Block, most_blocks> blocks_{};
    std::size_t end_ = 0;  // the slots in use lie before
    std::uint32_t serial_ = 0;
    std::size_t used_ = 0, made_ = 0, most_bytes_ = 0, missed_ = 0;
    Failure failure_;
    std::size_t hand_slot_ = 0, hand_offset_ = 0;  // of unmap_next()
};

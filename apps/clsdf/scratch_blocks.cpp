#include "scratch_blocks.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

constinit ScratchBlocks blocks;

std::size_t page_bytes() {
    static const auto bytes = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    return bytes;
}

/// A file without a name; negative after an error.
int make_file(int folder) {
    const int file = ::openat(folder, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
    // File systems without such files.
    static std::atomic<unsigned> number = 0;
    char name[64];
    std::snprintf(name, sizeof(name), ".clsdf-scratch-%ld-%u", static_cast<long>(::getpid()), number++);
    const int named = ::openat(folder, name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (named >= 0) ::unlinkat(folder, name, 0);
    return named;
}

/// Returns the system's error, or 0.
int reserve(int file, std::size_t bytes) {
    for (;;)
        if (const int error = ::posix_fallocate(file, 0, static_cast<off_t>(bytes)); error != EINTR) return error;
}

/// A mapping of the file at a multiple of the alignment; MAP_FAILED after an error.
void* map_file(int file, std::size_t bytes, std::size_t alignment) {
    if (alignment <= page_bytes()) return ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    const std::size_t room = bytes + alignment;
    void* const begin = ::mmap(nullptr, room, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (begin == MAP_FAILED) return MAP_FAILED;
    auto* const first = static_cast<std::byte*>(begin);
    const std::size_t before = (alignment - reinterpret_cast<std::uintptr_t>(begin) % alignment) % alignment;
    void* const mapped = ::mmap(first + before, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file, 0);
    if (mapped == MAP_FAILED) {
        ::munmap(begin, room);
        return MAP_FAILED;
    }
    if (before > 0) ::munmap(first, before);
    ::munmap(first + before + bytes, alignment - before);
    return mapped;
}

}  // namespace

ScratchBlocks& ScratchBlocks::of_process() {
    return blocks;
}

void ScratchBlocks::open_folder(int folder, std::size_t least_block) {
    const std::lock_guard lock(mutex_);
    folder_ = folder;
    failure_ = {};
    made_ = missed_ = 0;
    most_bytes_ = used_;
    least_block_ = std::max(least_block, std::size_t{1});
}

void ScratchBlocks::close_folder() {
    const std::lock_guard lock(mutex_);
    least_block_ = SIZE_MAX;
    folder_ = -1;
}

void* ScratchBlocks::add(std::size_t bytes, std::size_t alignment, bool& is_full) noexcept {
    is_full = false;
    if (bytes > SIZE_MAX / 4) return nullptr;
    const std::size_t whole_pages = (bytes + page_bytes() - 1) / page_bytes() * page_bytes();
    int folder = -1;
    {
        const std::lock_guard lock(mutex_);
        folder = folder_;
    }
    if (folder < 0) return nullptr;
    const int file = make_file(folder);
    if (file < 0 && (errno == EMFILE || errno == ENFILE)) {
        const std::lock_guard lock(mutex_);
        missed_ += whole_pages;
        return nullptr;
    }
    const int error = file < 0 ? errno : reserve(file, whole_pages);
    if (error != 0) {
        if (file >= 0) ::close(file);
        is_full = true;
        const std::lock_guard lock(mutex_);
        failure_ = {error, whole_pages, used_};
        return nullptr;
    }
    void* const mapped = map_file(file, whole_pages, alignment);
    if (mapped != MAP_FAILED && put({static_cast<std::byte*>(mapped), whole_pages, file})) return mapped;
    if (mapped != MAP_FAILED) ::munmap(mapped, whole_pages);
    ::close(file);
    const std::lock_guard lock(mutex_);
    missed_ += whole_pages;
    return nullptr;
}

bool ScratchBlocks::put(const Block& block) {
    const std::lock_guard lock(mutex_);
    std::size_t slot = 0;
    while (slot < end_ && blocks_[slot].address != nullptr) ++slot;
    if (slot == most_blocks) return false;
    blocks_[slot] = block;
    blocks_[slot].serial = ++serial_;
    end_ = std::max(end_, slot + 1);
    ++count_;
    ++made_;
    used_ += block.bytes;
    most_bytes_ = std::max(most_bytes_, used_);
    return true;
}

bool ScratchBlocks::remove_block(void* memory) noexcept {
    Block block;
    {
        const std::lock_guard lock(mutex_);
        std::size_t slot = 0;
        while (slot < end_ && blocks_[slot].address != memory) ++slot;
        if (slot == end_ || memory == nullptr) return false;
        block = blocks_[slot];
        // Under the lock: nothing else may be mapped there while the pieces of this block are unmapped.
        ::munmap(block.address, block.bytes);
        blocks_[slot].address = nullptr;
        while (end_ > 0 && blocks_[end_ - 1].address == nullptr) --end_;
        --count_;
        used_ -= block.bytes;
    }
    ::close(block.file);
    return true;
}

bool ScratchBlocks::contains(const void* address) const {
    const auto* const at = static_cast<const std::byte*>(address);
    return std::any_of(blocks_.begin(), blocks_.end(), [&](const Block& block) {
        return block.address != nullptr && at >= block.address && at < block.address + block.bytes;
    });
}

ScratchBlocks::Failure ScratchBlocks::failure() const {
    const std::lock_guard lock(mutex_);
    return failure_;
}

bool ScratchBlocks::unmap_next(Piece& piece, std::size_t& resident) {
    std::array<unsigned char, piece_bytes / smallest_page> pages;
    const std::size_t first_slot = hand_slot_, first_offset = hand_offset_;
    bool has_wrapped = false;
    for (;;) {
        if (hand_slot_ >= end_) {
            if (has_wrapped || end_ == 0) return false;
            has_wrapped = true;
            hand_slot_ = hand_offset_ = 0;
        }
        const Block& block = blocks_[hand_slot_];
        if (block.address == nullptr || hand_offset_ >= block.bytes) {
            ++hand_slot_;
            hand_offset_ = 0;
            continue;
        }
        if (has_wrapped && (hand_slot_ > first_slot || (hand_slot_ == first_slot && hand_offset_ > first_offset)))
            return false;
        piece = {hand_slot_, block.serial, hand_offset_, std::min(piece_bytes, block.bytes - hand_offset_)};
        hand_offset_ += piece_bytes;
        std::byte* const address = block.address + piece.offset;
        if (::mincore(address, piece.bytes, pages.data()) != 0) continue;
        const auto end = pages.begin() + static_cast<std::ptrdiff_t>((piece.bytes + page_bytes() - 1) / page_bytes());
        const auto count = std::count_if(pages.begin(), end, [](unsigned char page) { return (page & 1U) != 0; });
        if (count == 0) continue;
        resident = static_cast<std::size_t>(count) * page_bytes();
        ::madvise(address, piece.bytes, MADV_DONTNEED);  // of a shared file: the pages stay in the system's cache
        ::sync_file_range(block.file, static_cast<off_t>(piece.offset), static_cast<off_t>(piece.bytes),
                          SYNC_FILE_RANGE_WRITE);
        return true;
    }
}

void ScratchBlocks::evict(const Piece& piece) {
    const Block& block = blocks_[piece.slot];
    if (block.address == nullptr || block.serial != piece.serial) return;
    const auto offset = static_cast<off_t>(piece.offset), bytes = static_cast<off_t>(piece.bytes);
    ::sync_file_range(block.file, offset, bytes,
                      SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
    ::posix_fadvise(block.file, offset, bytes, POSIX_FADV_DONTNEED);  // but those that are mapped again
}

#ifndef CLSDF_WITHOUT_SCRATCH

namespace {

void* allocate(std::size_t bytes, std::size_t alignment) {
    bytes = std::max(bytes, std::size_t{1});
    for (;;) {
        if (blocks.takes(bytes)) {
            bool is_full = false;
            if (void* const block = blocks.add(bytes, alignment, is_full)) return block;
            if (is_full) throw std::bad_alloc();
        }
        const std::size_t rounded = alignment == 0 ? bytes : (bytes + alignment - 1) / alignment * alignment;
        void* const memory = alignment == 0 ? std::malloc(bytes) : std::aligned_alloc(alignment, rounded);
        if (memory != nullptr) return memory;
        const std::new_handler handler = std::get_new_handler();
        if (handler == nullptr) throw std::bad_alloc();
        handler();
    }
}

}  // namespace

// All forms of new and delete call these.

void* operator new(std::size_t bytes) {
    return allocate(bytes, 0);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
    if (!blocks.remove(memory)) std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    if (!blocks.remove(memory)) std::free(memory);
}
// Without these, g++ warns that the sized forms are the library's.
void operator delete(void* memory, std::size_t) noexcept {
    ::operator delete(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t alignment) noexcept {
    ::operator delete(memory, alignment);
}

#endif

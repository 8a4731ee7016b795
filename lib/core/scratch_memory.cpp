#include "core/scratch_memory.hpp"

#include "core/large_memory.hpp"

#include <algorithm>

namespace clsdf {

ScratchMemory::~ScratchMemory() {
    for (const Block& block : blocks_) free_large_memory(block.memory);
}

ScratchMemory::Computation::~Computation() {
    if (has_succeeded_ && scratch_.is_repeated_) {
        scratch_.trim();
    } else {
        scratch_.release();
    }
    scratch_.is_repeated_ = has_succeeded_;
}

void* ScratchMemory::allocate(std::size_t bytes) {
    // The smallest that is large enough, and not so large that its memory would be wasted.
    Block* best = nullptr;
    for (Block& block : blocks_)
        if (!block.is_taken && block.bytes >= bytes && block.bytes / 2 <= bytes &&
            (best == nullptr || block.bytes < best->bytes))
            best = &block;
    if (best == nullptr) {
        blocks_.reserve(blocks_.size() + 1);
        best = &blocks_.emplace_back(Block{allocate_large_memory(bytes), bytes});
    }
    best->is_taken = best->was_taken = true;
    return best->memory;
}

void ScratchMemory::give_back(void* memory) noexcept {
    for (Block& block : blocks_)
        if (block.memory == memory) block.is_taken = false;
}

void ScratchMemory::trim() noexcept {
    free_unless([](const Block& block) { return block.is_taken || block.was_taken; });
    for (Block& block : blocks_) block.was_taken = block.is_taken;
}

void ScratchMemory::release() noexcept {
    free_unless([](const Block& block) { return block.is_taken; });
}

std::size_t ScratchMemory::bytes() const {
    std::size_t bytes = 0;
    for (const Block& block : blocks_) bytes += block.bytes;
    return bytes;
}

template <class Predicate>
void ScratchMemory::free_unless(const Predicate& is_needed) noexcept {
    const auto unneeded = std::partition(blocks_.begin(), blocks_.end(), is_needed);
    for (auto block = unneeded; block != blocks_.end(); ++block) free_large_memory(block->memory);
    blocks_.erase(unneeded, blocks_.end());
}

}  // namespace clsdf

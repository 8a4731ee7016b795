#include "core/scratch_memory.hpp"

#include "core/large_memory.hpp"

#include <algorithm>

namespace clsdf {

ScratchMemory::~ScratchMemory() {
    for (const Block& block : blocks_) free_large_memory(block.memory);
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
    std::erase_if(blocks_, [](Block& block) {
        const bool is_idle = !block.is_taken && !block.was_taken;
        if (is_idle) free_large_memory(block.memory);
        block.was_taken = block.is_taken;
        return is_idle;
    });
}

}  // namespace clsdf

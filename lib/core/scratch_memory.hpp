#pragma once

#include <cstddef>
#include <vector>

namespace clsdf {

/// Keeps the memory of large arrays that are given back, for the next computation of the same kind: fresh pages cost
/// more than what is done with them. For one thread at a time.
class ScratchMemory {
public:
    ScratchMemory() = default;
    ScratchMemory(const ScratchMemory&) = delete;
    ScratchMemory& operator=(const ScratchMemory&) = delete;
    ~ScratchMemory();

    /// large_memory_bytes or more. Throws std::bad_alloc.
    void* allocate(std::size_t bytes);
    void give_back(void* memory) noexcept;

    /// Releases what was not in use since the last call.
    void trim() noexcept;

private:
    struct Block {
        void* memory;
        std::size_t bytes;
        bool is_taken = false;
        bool was_taken = false;  // since the last trim()
    };

    std::vector<Block> blocks_;
};

}  // namespace clsdf

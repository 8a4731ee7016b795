#pragma once

#include <cstddef>

namespace clsdf {

/// Arrays of this many bytes and more are worth large_memory.
constexpr std::size_t large_memory_bytes = std::size_t{4} << 20;

/// Memory for a large array, aligned to huge pages and on them where the system gives them: the page faults of a fresh
/// array cost many times what it takes to fill it (measured: 15 times at 4 KiB a page). Throws std::bad_alloc.
void* allocate_large_memory(std::size_t bytes);
void free_large_memory(void* memory) noexcept;

/// Asks for huge pages in memory from elsewhere that nothing was written to yet.
void advise_huge_pages(void* memory, std::size_t bytes) noexcept;

}  // namespace clsdf

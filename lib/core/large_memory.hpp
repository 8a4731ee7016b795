#pragma once

#include <cstddef>

namespace clsdf {

/// large_memory() pays for arrays of this many bytes and more.
constexpr std::size_t large_memory_bytes = std::size_t{4} << 20;

/// Memory for a large array, aligned to huge pages and on them if the system provides them: with pages of 4 KiB the
/// page faults of a fresh array cost many times its filling. Throws std::bad_alloc.
void* allocate_large_memory(std::size_t bytes);
void free_large_memory(void* memory) noexcept;

/// Memory for an array of any size, aligned to a cache line (64 bytes); from large_memory_bytes on, large memory.
/// Throws std::bad_alloc.
void* allocate_array(std::size_t count, std::size_t element);
void free_array(void* memory, std::size_t count, std::size_t element) noexcept;

/// Asks the system for huge pages in memory that is allocated, but not yet written to.
void advise_huge_pages(void* memory, std::size_t bytes) noexcept;

}  // namespace clsdf

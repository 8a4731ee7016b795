#pragma once

#include <cstddef>
#include <vector>

namespace clsdf {

/// Arrays of this many bytes and more are worth large_memory.
constexpr std::size_t large_memory_bytes = std::size_t{4} << 20;

/// Memory for a large array, aligned to huge pages and on them where the system gives them: the page faults of a fresh
/// array cost many times what it takes to fill it (measured: 15 times at 4 KiB a page). Throws std::bad_alloc.
void* allocate_large_memory(std::size_t bytes);
void free_large_memory(void* memory) noexcept;

/// Asks for huge pages in memory from elsewhere that nothing was written to yet.
void advise_huge_pages(void* memory, std::size_t bytes) noexcept;

/// Resizes a vector. Where it must grow, it takes memory for exactly this size, on huge pages where the system gives
/// them, and loses its values.
template <class Value>
void resize_on_huge_pages(std::vector<Value>& values, std::size_t size) {
    if (values.capacity() < size) {
        std::vector<Value>().swap(values);
        values.reserve(size);
        advise_huge_pages(values.data(), size * sizeof(Value));
    }
    values.resize(size);
}

}  // namespace clsdf

#pragma once

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

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

/// Returns what work() returns. Throws Error(out_of_memory) if the host has too little memory. what: follows "too
/// little memory" in the message.
template <typename Work>
decltype(auto) with_host_memory(const char* what, const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, fmt::format("the host has too little memory {}", what));
    }
}

/// Leaves new elements of plain types uninitialised. The memory is that of a field: on huge pages if it is large.
template <typename T>
struct DefaultInitializingAllocator {
    static_assert(alignof(T) <= 64);
    using value_type = T;

    DefaultInitializingAllocator() = default;
    template <typename U>
    // NOLINTNEXTLINE(google-explicit-constructor): what allocators convert to
    DefaultInitializingAllocator(const DefaultInitializingAllocator<U>&) {}

    T* allocate(std::size_t count) { return static_cast<T*>(allocate_array(count, sizeof(T))); }
    void deallocate(T* memory, std::size_t count) noexcept { free_array(memory, count, sizeof(T)); }

    template <typename Element>
    void construct(Element* place) noexcept(std::is_nothrow_default_constructible_v<Element>) {
        ::new (static_cast<void*>(place)) Element;
    }
    template <typename Element, typename... Arguments>
    void construct(Element* place, Arguments&&... arguments) {
        ::new (static_cast<void*>(place)) Element(std::forward<Arguments>(arguments)...);
    }

    template <typename U>
    bool operator==(const DefaultInitializingAllocator<U>&) const {
        return true;
    }
};

/// A vector whose new elements of plain types are uninitialised: code that fills a large array on all cores need not
/// wait for one core to clear it. Large ones lie on huge pages.
template <typename T>
using UninitializedVector = std::vector<T, DefaultInitializingAllocator<T>>;

}  // namespace clsdf

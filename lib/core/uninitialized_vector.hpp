#pragma once

#include "core/large_memory.hpp"
#include "core/scratch_memory.hpp"

#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf {

/// Takes the memory of large arrays from `scratch` where there is one; it must outlive them.
template <typename T>
struct DefaultInitializingAllocator {
    using value_type = T;
    using propagate_on_container_move_assignment = std::true_type;
    using propagate_on_container_swap = std::true_type;

    ScratchMemory* scratch = nullptr;

    DefaultInitializingAllocator() = default;
    // NOLINTNEXTLINE(google-explicit-constructor): vectors take the scratch memory itself
    DefaultInitializingAllocator(ScratchMemory* scratch_in) : scratch(scratch_in) {}
    template <typename U>
    // NOLINTNEXTLINE(google-explicit-constructor): what allocators convert to
    DefaultInitializingAllocator(const DefaultInitializingAllocator<U>& other) : scratch(other.scratch) {}

    T* allocate(std::size_t count) {
        if (!is_large(count)) return std::allocator<T>().allocate(count);
        if (count > std::size_t(-1) / sizeof(T)) throw std::bad_array_new_length();
        const std::size_t bytes = count * sizeof(T);
        return static_cast<T*>(scratch ? scratch->allocate(bytes) : allocate_large_memory(bytes));
    }
    void deallocate(T* memory, std::size_t count) noexcept {
        if (!is_large(count))
            std::allocator<T>().deallocate(memory, count);
        else if (scratch)
            scratch->give_back(memory);
        else
            free_large_memory(memory);
    }
    static bool is_large(std::size_t count) { return count > (large_memory_bytes - 1) / sizeof(T); }

    bool operator==(const DefaultInitializingAllocator& other) const { return scratch == other.scratch; }

    template <typename U>
    void construct(U* place) noexcept {
        ::new (static_cast<void*>(place)) U;
    }
    template <typename U, typename... Arguments>
    void construct(U* place, Arguments&&... arguments) {
        ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
    }
};

/// A vector whose new elements of plain types are left unset: those who fill large arrays on all cores do not wait for
/// one core to clear them, nor for its page faults; large ones lie on huge pages.
template <typename T>
using UninitializedVector = std::vector<T, DefaultInitializingAllocator<T>>;

}  // namespace clsdf

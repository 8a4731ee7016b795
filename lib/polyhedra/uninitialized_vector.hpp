#pragma once

#include "core/large_memory.hpp"

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

template <typename T>
struct DefaultInitializingAllocator : std::allocator<T> {
    T* allocate(std::size_t count) {
        if (count < large_memory_bytes / sizeof(T)) return std::allocator<T>::allocate(count);
        if (count > std::size_t(-1) / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(allocate_large_memory(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) noexcept {
        if (count < large_memory_bytes / sizeof(T))
            std::allocator<T>::deallocate(memory, count);
        else
            free_large_memory(memory);
    }

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

}  // namespace clsdf::polyhedra

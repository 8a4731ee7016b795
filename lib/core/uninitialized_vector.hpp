#pragma once

#include "core/large_memory.hpp"
#include "core/scratch_memory.hpp"

#include <clsdf/field_array.hpp>

#include <cstddef>
#include <new>
#include <type_traits>
#include <vector>

namespace clsdf {

/// Takes the memory of large arrays from `scratch` where there is one; it must outlive them.
template <typename T>
struct DefaultInitializingAllocator : detail::DefaultInitialization {
    static_assert(alignof(T) <= 64);
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
        if (count > std::size_t(-1) / sizeof(T)) throw std::bad_array_new_length();
        const std::size_t bytes = count * sizeof(T);
        return static_cast<T*>(takes_scratch(bytes) ? scratch->allocate(bytes) : detail::allocate_field_memory(bytes));
    }
    void deallocate(T* memory, std::size_t count) noexcept {
        const std::size_t bytes = count * sizeof(T);
        if (takes_scratch(bytes))
            scratch->give_back(memory);
        else
            detail::free_field_memory(memory, bytes);
    }
    bool takes_scratch(std::size_t bytes) const { return scratch != nullptr && bytes >= large_memory_bytes; }

    template <typename U>
    bool operator==(const DefaultInitializingAllocator<U>& other) const {
        return scratch == other.scratch;
    }
};

/// A vector whose new elements of plain types are left unset: those who fill large arrays on all cores do not wait for
/// one core to clear them, nor for its page faults; large ones lie on huge pages.
template <typename T>
using UninitializedVector = std::vector<T, DefaultInitializingAllocator<T>>;

}  // namespace clsdf

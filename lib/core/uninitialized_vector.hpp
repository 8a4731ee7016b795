#pragma once

#include <clsdf/field_array.hpp>

#include <cstddef>
#include <new>
#include <vector>

namespace clsdf {

/// As the memory of a field: on huge pages if it is large.
template <typename T>
struct DefaultInitializingAllocator : detail::DefaultInitialization {
    static_assert(alignof(T) <= 64);
    using value_type = T;

    DefaultInitializingAllocator() = default;
    template <typename U>
    // NOLINTNEXTLINE(google-explicit-constructor): what allocators convert to
    DefaultInitializingAllocator(const DefaultInitializingAllocator<U>&) {}

    T* allocate(std::size_t count) {
        if (count > std::size_t(-1) / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(detail::allocate_field_memory(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) noexcept { detail::free_field_memory(memory, count * sizeof(T)); }

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

#pragma once

#include "core/large_memory.hpp"

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf {

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

#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

template <typename T>
struct DefaultInitializingAllocator : std::allocator<T> {
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
/// one core to clear them, nor for its page faults.
template <typename T>
using UninitializedVector = std::vector<T, DefaultInitializingAllocator<T>>;

}  // namespace clsdf::polyhedra

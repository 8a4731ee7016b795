#pragma once

#include <clsdf/export.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf {

namespace detail {

/// Begins on a line of memory, 64 bytes; from 4 MiB on, on a huge page, 2 MiB, and on such pages where the system gives
/// them. Throws std::bad_alloc.
CLSDF_EXPORT void* allocate_field_memory(std::size_t bytes);
CLSDF_EXPORT void free_field_memory(void* memory, std::size_t bytes) noexcept;

/// Of an allocator: elements that are made of nothing are left unset.
struct DefaultInitialization {
    template <typename Element>
    void construct(Element* place) noexcept(std::is_nothrow_default_constructible_v<Element>) {
        ::new (static_cast<void*>(place)) Element;
    }
    template <typename Element, typename... Arguments>
    void construct(Element* place, Arguments&&... arguments) {
        ::new (static_cast<void*>(place)) Element(std::forward<Arguments>(arguments)...);
    }
};

}  // namespace detail

/// Memory that a field is stored to fastest, whose elements are left unset.
template <typename Value>
struct CLSDF_EXPORT FieldAllocator : detail::DefaultInitialization {
    static_assert(alignof(Value) <= 64);
    using value_type = Value;
    using is_always_equal = std::true_type;

    FieldAllocator() = default;
    template <typename Other>
    // NOLINTNEXTLINE(google-explicit-constructor): what allocators convert to
    FieldAllocator(const FieldAllocator<Other>&) noexcept {}

    Value* allocate(std::size_t count) {
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(Value)) throw std::bad_array_new_length();
        return static_cast<Value*>(detail::allocate_field_memory(count * sizeof(Value)));
    }
    void deallocate(Value* memory, std::size_t count) noexcept {
        detail::free_field_memory(memory, count * sizeof(Value));
    }

    template <typename Other>
    bool operator==(const FieldAllocator<Other>&) const noexcept {
        return true;
    }
};

/// A std::vector for the samples of a grid, in memory that they are stored to fastest: it begins on a line of memory
/// (64 bytes) and, from 4 MiB on, lies on huge pages where the system gives them. (Measured on a processor: in a plain
/// std::vector a computation takes up to a fifth longer.)
///
/// New elements are left unset, those of `FieldArray<float>(n)` and of `resize(n)` too: whoever computes a field sets
/// every one of them, and need not wait until one core has cleared them. `FieldArray<float>(n, 0.0F)` sets them.
template <typename Value>
using FieldArray = std::vector<Value, FieldAllocator<Value>>;

}  // namespace clsdf

// Compiled with the library: in a program's build without optimisation each element would take a call.
extern template class CLSDF_EXPORT std::vector<float, clsdf::FieldAllocator<float>>;
extern template class CLSDF_EXPORT std::vector<double, clsdf::FieldAllocator<double>>;
extern template class CLSDF_EXPORT std::vector<std::uint32_t, clsdf::FieldAllocator<std::uint32_t>>;
extern template class CLSDF_EXPORT std::vector<std::uint8_t, clsdf::FieldAllocator<std::uint8_t>>;

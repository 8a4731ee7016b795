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

/// Memory aligned to a cache line (64 bytes); from 4 MiB on, aligned to a huge page (2 MiB), and on huge pages if the
/// system provides them. Throws std::bad_alloc.
CLSDF_EXPORT void* allocate_field_memory(std::size_t bytes);
CLSDF_EXPORT void free_field_memory(void* memory, std::size_t bytes) noexcept;

/// The part of an allocator that leaves new elements of plain types uninitialised.
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

/// An allocator of FieldArray: memory for fast stores, with uninitialised elements.
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

/// A std::vector for the samples of a grid, in memory for fast stores: it is aligned to a cache line (64 bytes) and,
/// from 4 MiB on, lies on huge pages if the system provides them.
///
/// New elements are uninitialised, also those of `FieldArray<float>(n)` and of `resize(n)`: a computation sets all of
/// them, and need not wait until one core has cleared them. `FieldArray<float>(n, 0.0F)` sets them.
template <typename Value>
using FieldArray = std::vector<Value, FieldAllocator<Value>>;

}  // namespace clsdf

// Compiled with the library: in a program's build without optimisation each element would take a call.
extern template class CLSDF_EXPORT std::vector<float, clsdf::FieldAllocator<float>>;
extern template class CLSDF_EXPORT std::vector<double, clsdf::FieldAllocator<double>>;
extern template class CLSDF_EXPORT std::vector<std::uint32_t, clsdf::FieldAllocator<std::uint32_t>>;
extern template class CLSDF_EXPORT std::vector<std::uint8_t, clsdf::FieldAllocator<std::uint8_t>>;

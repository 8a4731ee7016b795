#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf {

namespace detail {

/// Begins on a line of memory; from 4 MiB on, on a huge page where the system gives them. Throws std::bad_alloc.
void* allocate_field_memory(std::size_t bytes);
void free_field_memory(void* memory, std::size_t bytes) noexcept;

}  // namespace detail

/// For FieldArray.
template <typename Value>
struct FieldAllocator {
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

    template <typename Element>
    void construct(Element* place) noexcept(std::is_nothrow_default_constructible_v<Element>) {
        ::new (static_cast<void*>(place)) Element;
    }
    template <typename Element, typename... Arguments>
    void construct(Element* place, Arguments&&... arguments) {
        ::new (static_cast<void*>(place)) Element(std::forward<Arguments>(arguments)...);
    }

    bool operator==(const FieldAllocator&) const = default;
};

/// A std::vector for the samples of a grid, in memory that they are stored to fastest: it begins on a line of memory
/// and, if it is large, lies on huge pages. (Measured: a computation takes up to a fifth longer in a plain std::vector,
/// and its first one several times as long.) New elements are left unset, `FieldArray<float>(n)` too: whoever computes
/// a field sets every one of them, and need not wait until one core has cleared them.
template <typename Value>
using FieldArray = std::vector<Value, FieldAllocator<Value>>;

}  // namespace clsdf

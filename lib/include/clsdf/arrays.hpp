#pragma once

#include <clsdf/export.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <ranges>
#include <tuple>
#include <type_traits>

typedef struct _cl_mem* cl_mem;

namespace clsdf {

/// The type of the numbers in an array. The values of the enumerators never change.
enum class ElementType : std::int32_t {
    automatic = 0,  ///< of an output: the type that output_table() states
    float32 = 1,
    float64 = 2,
    int32 = 3,
    int64 = 4,
    uint32 = 5,
    uint64 = 6,
    uint8 = 7,
};

/// Bytes of one number; 0 for `automatic`.
constexpr std::size_t bytes_of(ElementType type) {
    switch (type) {
        case ElementType::automatic:
            return 0;
        case ElementType::uint8:
            return 1;
        case ElementType::float64:
        case ElementType::int64:
        case ElementType::uint64:
            return 8;
        default:
            return 4;
    }
}

/// "float", "double", "int32" and so on.
CLSDF_EXPORT const char* name_of(ElementType type);

namespace detail {
template <typename Value>
constexpr std::optional<ElementType> type_of_number() {
    if constexpr (std::is_same_v<Value, float>) return ElementType::float32;
    if constexpr (std::is_same_v<Value, double>) return ElementType::float64;
    if constexpr (std::is_same_v<Value, std::uint8_t>) return ElementType::uint8;
    if constexpr (std::is_integral_v<Value>) {  // an incomplete type has no size
        if constexpr (sizeof(Value) == 4) return std::is_signed_v<Value> ? ElementType::int32 : ElementType::uint32;
        if constexpr (sizeof(Value) == 8) return std::is_signed_v<Value> ? ElementType::int64 : ElementType::uint64;
    }
    return std::nullopt;
}

/// The type of the numbers of an array's elements, which are numbers or triples of numbers.
template <typename Value>
constexpr std::optional<ElementType> element_type() {
    if constexpr (requires {
                      typename Value::value_type;
                      std::tuple_size<Value>::value;
                  }) {
        if constexpr (std::tuple_size_v<Value> == 3) return type_of_number<typename Value::value_type>();
        return std::nullopt;
    } else {
        return type_of_number<Value>();
    }
}

/// Arrays of numbers, or of triples of numbers.
template <typename Array>
concept NumberArray = std::ranges::contiguous_range<Array> && element_type<std::ranges::range_value_t<Array>>()
.has_value();

/// A temporary that owns its elements: a view of it would dangle. Views such as std::span own none. The elements of an
/// initializer list live until the end of the calling expression.
template <typename Array>
concept DyingArray =
    std::ranges::contiguous_range<Array> && !std::ranges::borrowed_range<Array> &&
    !std::same_as<std::remove_cvref_t<Array>, std::initializer_list<std::ranges::range_value_t<Array>>>;
}  // namespace detail

/// Where the numbers of an array lie in the caller's memory. An array has items: vertices, triangles, points or
/// samples, each of one number or of several components.
struct ArrayLayout {
    static constexpr std::size_t unknown_size = static_cast<std::size_t>(-1);

    ElementType type = ElementType::automatic;
    /// Bytes before the first item, a multiple of a number's bytes.
    std::size_t offset = 0;
    /// Bytes from an item to the next one: along x, y and z for samples of a grid; for other arrays, the first stride
    /// alone. Multiples of a number's bytes; negative ones run backwards from the first item. Zeros: packed, x fastest.
    std::array<std::ptrdiff_t, 3> strides{};
    /// Bytes from a component of an item to its next one, also negative; 0: side by side. If it is set and `strides`
    /// are not, the first components of all items lie side by side, then the second ones (structure of arrays).
    std::ptrdiff_t component_stride = 0;
    /// Bytes of host memory, counted from its address. If they are known, an array that reaches beyond them is refused.
    std::size_t bytes = unknown_size;
};

/// An array that a call reads: positions of three floats or doubles, or triangles of three integers. Signed integers
/// count as unsigned ones: a negative index is out of range. It lies on the host or, as a buffer, on the device.
/// Nothing is copied; the memory must outlive the use.
struct InputArray : ArrayLayout {
    const void* host = nullptr;
    cl_mem device = nullptr;  ///< a buffer that the host may read (not CL_MEM_HOST_NO_ACCESS, CL_MEM_HOST_WRITE_ONLY)
    std::size_t count = 0;    ///< of items

    InputArray() = default;
    /// An array of triples (Vec3, Triangle, any std::array of three numbers), or of three numbers an item. A temporary
    /// container does not compile: give it a name that lives as long as this.
    template <detail::NumberArray Array>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): any array of numbers
    InputArray(Array&& array) : host(std::ranges::data(array)) {
        type = *detail::element_type<std::ranges::range_value_t<Array>>();
        bytes = std::ranges::size(array) * sizeof(std::ranges::range_value_t<Array>);
        count = bytes / (3 * bytes_of(type));
    }
    template <detail::NumberArray Array>
    requires detail::DyingArray<Array>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): as above
    InputArray(Array&& array)
    = delete;
    /// Items at any distance from each other, for instance four floats apart.
    template <typename Value>
    requires(detail::element_type<Value>().has_value())
        InputArray(const Value* first, std::size_t count_in, std::ptrdiff_t stride = 0,
                   std::ptrdiff_t component_stride_in = 0)
        : host(first), count(count_in) {
        type = *detail::element_type<Value>();
        strides[0] = stride;
        component_stride = component_stride_in;
    }
    /// Memory of the device, a buffer.
    InputArray(cl_mem memory, ElementType type_in, std::size_t count_in) : device(memory), count(count_in) {
        type = type_in;
    }
};

/// An array that a call writes: the values of one output. It lies on the host or, as a buffer, on the device. Values
/// between its items stay as they are.
struct OutputArray : ArrayLayout {
    void* host = nullptr;
    cl_mem device = nullptr;
    /// In a BlockSet: bytes from a block's first sample to that of the next block; 0: the blocks follow one another.
    std::ptrdiff_t block_stride = 0;
    /// The host's memory is pinned: mapped memory of a buffer with CL_MEM_ALLOC_HOST_PTR, or page-locked by another
    /// interface of the device's driver. A packed field is then read into it directly, without a copy by the host. If
    /// it is not true, the call is slower, not wrong.
    bool is_pinned = false;

    OutputArray() = default;
    /// An array of the caller's. Without strides its size must be exactly the output's. A temporary container does not
    /// compile.
    template <detail::NumberArray Array>
    requires(!detail::DyingArray<Array> &&
             !std::is_const_v<std::remove_reference_t<std::ranges::range_reference_t<Array>>>)
        // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): any array is an output
        OutputArray(Array&& array)
        : host(std::ranges::data(array)) {
        type = *detail::element_type<std::ranges::range_value_t<Array>>();
        bytes = std::ranges::size(array) * sizeof(std::ranges::range_value_t<Array>);
    }
    template <detail::DyingArray Array>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): as above
    OutputArray(Array&& array) = delete;
    /// Memory of unknown size that holds all that is addressed, from its first item on.
    template <typename Value>
    requires(detail::element_type<Value>().has_value() && !std::is_const_v<Value>)
        // NOLINTNEXTLINE(google-explicit-constructor): memory is an output
        OutputArray(Value* first, const std::array<std::ptrdiff_t, 3>& strides_in = {},
                    std::ptrdiff_t component_stride_in = 0)
        : host(first) {
        type = *detail::element_type<Value>();
        strides = strides_in;
        component_stride = component_stride_in;
    }
    /// Memory of the device, a buffer.
    // NOLINTNEXTLINE(google-explicit-constructor): a buffer is an output
    OutputArray(cl_mem memory, ElementType type_in = ElementType::automatic) : device(memory) { type = type_in; }

    bool is_given() const { return host != nullptr || device != nullptr; }
};

/// Bytes of a buffer of the device, from an offset on that is a multiple of 8. The buffer is one that kernels may
/// write.
struct DeviceRange {
    cl_mem memory = nullptr;
    std::size_t offset = 0;
};

}  // namespace clsdf

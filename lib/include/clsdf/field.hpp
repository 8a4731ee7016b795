#pragma once

#include <clsdf/export.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <ranges>
#include <span>
#include <string>

namespace clsdf {

/// An array for the samples of a grid, in memory for fast stores: it is aligned to 64 bytes and lies on huge pages if
/// it is large and the system provides them. `Value` is float, double, std::uint32_t, std::uint8_t or std::byte.
///
/// New elements are uninitialised, also those of `FieldArray<float>(n)` and of `resize(n)`: a computation sets all of
/// them, and need not wait until one core has cleared them. `FieldArray<float>(n, 0.0F)` sets them. A function that
/// allocates throws std::bad_alloc. An array that was moved from is empty.
template <typename Value>
class CLSDF_EXPORT FieldArray {
public:
    using value_type = Value;
    using size_type = std::size_t;
    using difference_type = std::ptrdiff_t;
    using reference = Value&;
    using const_reference = const Value&;
    using iterator = Value*;
    using const_iterator = const Value*;

    FieldArray() noexcept = default;
    explicit FieldArray(std::size_t size);
    FieldArray(std::size_t size, Value value);
    FieldArray(std::initializer_list<Value> values);
    FieldArray(const FieldArray& other);
    FieldArray(FieldArray&& other) noexcept;
    FieldArray& operator=(FieldArray other) noexcept;
    ~FieldArray();

    /// The first elements stay. Pointers to them hold if the size does not grow.
    void resize(std::size_t size);
    void resize(std::size_t size, Value value);
    void push_back(Value value);
    void pop_back() { --size_; }
    /// `values` may not be a part of this array.
    void append(std::span<const Value> values);
    /// Releases the memory.
    void clear() noexcept;

    Value* data() noexcept { return data_; }
    const Value* data() const noexcept { return data_; }
    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    Value& operator[](std::size_t n) { return data_[n]; }
    const Value& operator[](std::size_t n) const { return data_[n]; }
    Value& front() { return data_[0]; }
    const Value& front() const { return data_[0]; }
    Value& back() { return data_[size_ - 1]; }
    const Value& back() const { return data_[size_ - 1]; }
    Value* begin() noexcept { return data_; }
    const Value* begin() const noexcept { return data_; }
    Value* end() noexcept { return data_ + size_; }
    const Value* end() const noexcept { return data_ + size_; }

    bool operator==(const FieldArray& other) const;

private:
    void reserve(std::size_t size);

    Value* data_ = nullptr;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

extern template class FieldArray<float>;
extern template class FieldArray<double>;
extern template class FieldArray<std::uint32_t>;
extern template class FieldArray<std::uint8_t>;
extern template class FieldArray<std::byte>;

/// The properties of a field without its values.
struct FieldDescription {
    Grid grid;
    Band band;
    SignRule sign = SignRule::none;  ///< `automatic` if a file of another program states none
    std::string mesh_name;
    /// Distances and gradients are negated, also zeros and what lies beyond the band: -0 on the surface. So negating
    /// them again gives the same bits. Fields that are computed are negative inside; see Field::negate().
    bool positive_inside = false;
    /// The groups of the mesh, or null. A .vti or .vtkhdf with the output triangle gets the group of each sample, too.
    std::shared_ptr<const FaceGroups> groups{};
    /// Of the sign rule `below`: z of the floor; nothing if there is none, or if a file does not say.
    std::optional<double> floor{};
};

namespace detail {
/// Room for outputs of later versions, so that a new one changes no layout.
inline constexpr std::size_t most_outputs = 16;

// The types of output_table()'s elements.
using uint8 = std::uint8_t;
using uint32 = std::uint32_t;
using float32 = float;
using float64 = double;

constexpr std::size_t index_of(Output output) {
    return static_cast<std::size_t>(output);
}

template <typename Value, typename Byte>
std::span<Value> values_in(std::span<Byte> bytes) {
    return {reinterpret_cast<Value*>(bytes.data()), bytes.size() / sizeof(Value)};
}
}  // namespace detail

/// Values of samples or points in memory of their owner: an array for each output, x fastest, the components of a
/// vector side by side. An array is empty if there are no values of that output.
class FieldSlab {
public:
    std::span<const std::byte> bytes(Output output) const { return bytes_[detail::index_of(output)]; }
    /// `values` have the type that output_table() states for the output, and must outlive this. Throws
    /// Error(invalid_argument) for another type.
    template <std::ranges::contiguous_range Values>
    void set(Output output, const Values& values) {
        using Value = std::ranges::range_value_t<Values>;
        if constexpr (detail::element_type<Value>().has_value())
            detail::check_type(output, *detail::element_type<Value>());
        bytes_[detail::index_of(output)] = std::as_bytes(std::span(values));
    }

    /// The outputs that have values.
    OutputSet outputs() const {
        OutputSet set;
        for (std::size_t i = 0; i < bytes_.size(); ++i)
            if (!bytes_[i].empty()) set.insert(static_cast<Output>(i));
        return set;
    }

    // The values of each output: distance(), triangle(), site(), closest(), gradient(), barycentric(), offset().
#define CLSDF_VALUES(name, description, element, components, number)          \
    std::span<const detail::element> name() const {                           \
        return detail::values_in<const detail::element>(bytes(Output::name)); \
    }
    CLSDF_VALUES(distance, , float32, 1, 0)
    CLSDF_OUTPUTS(CLSDF_VALUES)
#undef CLSDF_VALUES

private:
    std::array<std::span<const std::byte>, detail::most_outputs> bytes_{};
};

/// A field on the host: for each output that it has an array of grid.sample_count() samples, x fastest, the components
/// of a vector side by side.
struct CLSDF_EXPORT Field : FieldDescription {
    Field() = default;
    /// Has room for these outputs of the grid's samples. The values are not initialised, see FieldArray. Throws
    /// Error(invalid_argument) for a grid that makes no sense, Error(out_of_memory).
    explicit Field(const FieldDescription& description, OutputSet outputs = Output::distance);

    std::span<std::byte> bytes(Output output) { return arrays_[detail::index_of(output)]; }
    std::span<const std::byte> bytes(Output output) const { return arrays_[detail::index_of(output)]; }

    /// The outputs that it has.
    OutputSet outputs() const { return slab().outputs(); }
    /// Makes room for `samples` values of an output; the first ones stay. Throws std::bad_alloc.
    std::span<std::byte> resize(Output output, std::size_t samples);
    /// Releases the output's memory.
    void erase(Output output) { arrays_[detail::index_of(output)].clear(); }

    /// Negates the distances and the gradients, but for NaN, and changes `positive_inside`.
    void negate();

    /// A view of all values.
    FieldSlab slab() const;
    /// The arrays of all outputs that it has, for DistanceTransform::compute().
    OutputTargets targets();

    // The values of each output: distance(), triangle(), site(), closest(), gradient(), barycentric(), offset(). Const
    // spans of mutable values: an assignment to the span itself, which would change nothing, does not compile.
#define CLSDF_VALUES(name, description, element, components, number)    \
    const std::span<detail::element> name() {                           \
        return detail::values_in<detail::element>(bytes(Output::name)); \
    }                                                                   \
    std::span<const detail::element> name() const {                     \
        return slab().name();                                           \
    }
    CLSDF_VALUES(distance, , float32, 1, 0)
    CLSDF_OUTPUTS(CLSDF_VALUES)
#undef CLSDF_VALUES

private:
    std::array<FieldArray<std::byte>, detail::most_outputs> arrays_;
};

}  // namespace clsdf

#pragma once

#include <clsdf/export.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>

namespace clsdf {

/// An array for the samples of a grid, in memory for fast stores: it is aligned to a cache line (64 bytes) and, from 4
/// MiB on, lies on huge pages if the system provides them. `Value` is float, double, std::uint32_t or std::uint8_t.
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
    FieldArray& operator=(const FieldArray& other);
    FieldArray& operator=(FieldArray&& other) noexcept;
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

/// The properties of a field without its values.
struct FieldDescription {
    Grid grid;
    Band band;
    SignRule sign = SignRule::none;  ///< `automatic` if a file of another program states none
    std::string mesh_name;
};

/// A computed field on the host. Each array has grid.sample_count() samples, x fastest, or is empty if the output was
/// not asked for. New elements of an array are not initialised, see FieldArray.
struct Field : FieldDescription, PerOutput<FieldArray> {};

namespace detail {
template <typename Element>
using SpanOf = std::span<const Element>;
}

/// The values of some slices of a field, z after z: grid.size[0] * grid.size[1] samples for each, x fastest. An array
/// is empty if the field does not hold that output.
using FieldSlab = PerOutput<detail::SpanOf>;

}  // namespace clsdf

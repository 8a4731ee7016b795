#pragma once

#include <clsdf/field.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace clsdf {

enum class ValueType { float32, float64, uint32, uint8 };

/// A value is an index or a number without a fraction.
constexpr bool is_whole(ValueType type) {
    return type == ValueType::uint32 || type == ValueType::uint8;
}

/// Bytes of a value.
std::size_t width_of(ValueType type);

/// One array of a field with the properties that formats need: a row of the table in kernels/outputs.h with its
/// members.
struct OutputKind {
    const char* name;         ///< in files, and in the names of files
    const char* content;      ///< in words
    ValueType type;           ///< of one value
    std::int64_t components;  ///< values of one sample, which lie side by side
    bool (*wanted)(const Outputs& outputs);
    std::span<const std::byte> (*bytes)(const FieldSlab& slab);
    /// Resizes the array to this number of values.
    std::span<std::byte> (*allocate)(Field& field, std::size_t values);

    std::size_t sample_bytes() const { return width_of(type) * static_cast<std::size_t>(components); }
};

const OutputKind& distance_kind();
/// The outputs beside the distance.
std::span<const OutputKind> extra_kinds();
/// The distance first, then the others asked for.
std::vector<OutputKind> kinds_of(const Outputs& outputs);

/// Resizes the arrays to the samples of the field's grid.
std::span<std::byte> allocate_output(const OutputKind& kind, Field& field);

FieldSlab slab_of(const Field& field);
/// The outputs that the field has.
Outputs outputs_of(const Field& field);

}  // namespace clsdf

#pragma once

#include <clsdf/field.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace clsdf {

enum class ValueType { float32, float64, uint32 };

/// Bytes of a value.
std::size_t width_of(ValueType type);

/// One of the arrays of a field, and all that the formats need to know about it. A new one is a row of the table in
/// outputs.cpp beside its members in Field, FieldSlab and Outputs.
struct OutputKind {
    const char* name;         ///< in files, and in the names of files
    const char* content;      ///< in words
    ValueType type;           ///< of one value
    std::int64_t components;  ///< values of one sample, which lie side by side
    bool (*wanted)(const Outputs& outputs);
    std::span<const std::byte> (*bytes)(const FieldSlab& slab);
    /// Makes room for so many samples.
    std::span<std::byte> (*allocate)(Field& field, std::size_t samples);

    std::size_t sample_bytes() const { return width_of(type) * static_cast<std::size_t>(components); }
};

const OutputKind& distance_kind();
/// What a field may hold beside the distance.
std::span<const OutputKind> extra_kinds();
/// The distance first, then the others asked for.
std::vector<OutputKind> kinds_of(const Outputs& outputs);

FieldSlab slab_of(const Field& field);
/// What the field holds.
Outputs outputs_of(const Field& field);

}  // namespace clsdf

#pragma once

#include "outputs.h"

#include <clsdf/field.hpp>
#include <clsdf/outputs.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// A row of the table of outputs (kernels/outputs.h), or the distance.
struct OutputRow {
    enum Element : std::uint8_t { real, uint32, uint8 };

    const char* name;     ///< that of the members, in files, and in the names of files
    const char* content;  ///< in words
    Element element;
    std::size_t components;
    std::uint32_t bit;  ///< in sets of outputs; 0 for the distance

    std::size_t sample_bytes(bool in_double) const {
        return components * (element == uint8 ? 1U : element == real && in_double ? 8U : 4U);
    }
};

namespace detail {
template <typename>
using ByteOf = char;
static_assert(sizeof(PerOutput<ByteOf>) == 1 + CLSDF_OUTPUT_COUNT, "the table and PerOutput have the same outputs");
}  // namespace detail

/// Calls visit(row, a.distance, b.distance, ...), then the same for every other output, of structs that have a member
/// for each.
template <typename Visit, typename... Sets>
void for_each_output(const Visit& visit, Sets&&... sets) {
    visit(OutputRow{"distance", "distance", OutputRow::real, 1, 0}, sets.distance...);
#define CLSDF_VISIT(name, content, element, components) \
    visit(OutputRow{#name, content, OutputRow::element, components, 1U << CLSDF_OUTPUT_##name}, sets.name...);
    CLSDF_OUTPUTS(CLSDF_VISIT)
#undef CLSDF_VISIT
}

/// The same without the distance.
template <typename Visit, typename... Sets>
void for_each_extra(const Visit& visit, Sets&&... sets) {
#define CLSDF_VISIT(name, content, element, components) \
    visit(OutputRow{#name, content, OutputRow::element, components, 1U << CLSDF_OUTPUT_##name}, sets.name...);
    CLSDF_OUTPUTS(CLSDF_VISIT)
#undef CLSDF_VISIT
}

/// The bits of the requested outputs.
inline std::uint32_t bits_of(const Outputs& outputs) {
    std::uint32_t bits = 0;
    for_each_extra([&](const OutputRow& row, bool wanted) { bits |= wanted ? row.bit : 0; }, outputs);
    return bits;
}

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

#pragma once

#include <clsdf/outputs.hpp>

#include "outputs.h"

#include <cstddef>
#include <cstdint>

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

}  // namespace clsdf

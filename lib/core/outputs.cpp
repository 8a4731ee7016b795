#include "core/outputs.hpp"

#include "layout.h"

#include <array>

namespace clsdf {
namespace {

static_assert(no_triangle == CLSDF_NO_TRIANGLE);

template <typename Value>
constexpr ValueType type_of() {
    return std::is_same_v<Value, float>           ? ValueType::float32
           : std::is_same_v<Value, double>        ? ValueType::float64
           : std::is_same_v<Value, std::uint32_t> ? ValueType::uint32
                                                  : ValueType::uint8;
}

// The row for a member of FieldSlab and the one of the same name of Field.
template <auto slab_member, auto field_member>
constexpr OutputKind kind(const char* name, const char* content, std::int64_t components,
                          bool (*wanted)(const Outputs&)) {
    using Span = std::remove_cvref_t<decltype(std::declval<FieldSlab>().*slab_member)>;
    return {name,
            content,
            type_of<typename Span::value_type>(),
            components,
            wanted,
            [](const FieldSlab& slab) { return std::as_bytes(slab.*slab_member); },
            [](Field& field, std::size_t values) {
                (field.*field_member).resize(values);
                return std::as_writable_bytes(std::span(field.*field_member));
            }};
}

constexpr OutputKind distance =
    kind<&FieldSlab::distance, &Field::distance>("distance", "distance", 1, [](const Outputs&) { return true; });

#define CLSDF_KIND(name, content, element, components)               \
    kind<&FieldSlab::name, &Field::name>(#name, content, components, \
                                         [](const Outputs& outputs) { return outputs.name; }),
constexpr std::array extras{CLSDF_OUTPUTS(CLSDF_KIND)};
#undef CLSDF_KIND

}  // namespace

std::size_t width_of(ValueType type) {
    return type == ValueType::float64 ? 8 : type == ValueType::uint8 ? 1 : 4;
}

const OutputKind& distance_kind() {
    return distance;
}

std::span<const OutputKind> extra_kinds() {
    return extras;
}

std::vector<OutputKind> kinds_of(const Outputs& outputs) {
    std::vector<OutputKind> kinds{distance};
    for (const OutputKind& extra : extras)
        if (extra.wanted(outputs)) kinds.push_back(extra);
    return kinds;
}

std::span<std::byte> allocate_output(const OutputKind& kind, Field& field) {
    return kind.allocate(field, field.grid.sample_count() * static_cast<std::size_t>(kind.components));
}

FieldSlab slab_of(const Field& field) {
    FieldSlab slab;
    for_each_output([](const OutputRow&, auto& span, const auto& array) { span = array; }, slab, field);
    return slab;
}

Outputs outputs_of(const Field& field) {
    Outputs outputs;
    for_each_extra([](const OutputRow&, bool& wanted, const auto& array) { wanted = !array.empty(); }, outputs, field);
    return outputs;
}

}  // namespace clsdf

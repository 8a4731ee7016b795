#include "field/outputs.hpp"

#include <array>

namespace clsdf {
namespace {

// The row for a member of FieldSlab and the one of the same name of Field.
template <auto slab_member, auto field_member>
constexpr OutputKind kind(const char* name, const char* content, ValueType type, std::int64_t components,
                          bool (*wanted)(const Outputs&)) {
    return {name,
            content,
            type,
            components,
            wanted,
            [](const FieldSlab& slab) { return std::as_bytes(slab.*slab_member); },
            [](Field& field, std::size_t samples) {
                (field.*field_member).resize(samples);
                return std::as_writable_bytes(std::span(field.*field_member));
            }};
}

constexpr OutputKind distance = kind<&FieldSlab::distance, &Field::distance>("distance", "distance", ValueType::float32,
                                                                             1, [](const Outputs&) { return true; });

constexpr std::array extras{
    kind<&FieldSlab::triangle, &Field::triangle>("triangle", "nearest triangle", ValueType::uint32, 1,
                                                 [](const Outputs& outputs) { return outputs.triangle; }),
};

}  // namespace

std::size_t width_of(ValueType type) {
    return type == ValueType::float64 ? 8 : 4;
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

FieldSlab slab_of(const Field& field) {
    return {field.distance, field.triangle};
}

Outputs outputs_of(const Field& field) {
    return {.triangle = !field.triangle.empty()};
}

}  // namespace clsdf

#pragma once

#include "output_numbers.h"

#include <clsdf/field.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// A value for each output of <clsdf/output_table.h>, in which a new output begins. A number without an output has one,
/// too.
template <typename Value>
class PerOutput {
public:
    Value& operator[](Output output) { return values_[static_cast<std::size_t>(output)]; }
    const Value& operator[](Output output) const { return values_[static_cast<std::size_t>(output)]; }

private:
    std::array<Value, CLSDF_OUTPUT_COUNT> values_{};
};

/// The outputs beside the distance.
inline std::span<const OutputInfo> extra_outputs() {
    return output_table().subspan(1);
}

/// Calls visit(info, a[output], b[output], ...) for each output, the distance first.
template <typename Visit, typename... Values>
void for_each_output(const Visit& visit, Values&&... values) {
    for (const OutputInfo& info : output_table()) visit(info, values[info.output]...);
}

/// The output's bit in a set of outputs, also in kernels.
inline std::uint32_t bit_of(const OutputInfo& info) {
    return OutputSet(info.output).bits();
}

/// The output has floats, or doubles if the caller asks for them.
inline bool may_be_double(const OutputInfo& info) {
    return info.type == ElementType::float32;
}

/// The output has real numbers.
inline bool is_real(const OutputInfo& info) {
    return may_be_double(info) || info.type == ElementType::float64;
}

/// Bytes of a sample. in_double: real numbers are doubles.
inline std::size_t sample_bytes(const OutputInfo& info, bool in_double) {
    const std::size_t element = may_be_double(info) && in_double ? 8 : bytes_of(info.type);
    return element * info.components;
}

/// A value is an index or a number without a fraction.
constexpr bool is_whole(ElementType type) {
    return type != ElementType::float32 && type != ElementType::float64;
}

/// The distance first, then the others that are asked for.
std::vector<OutputInfo> infos_of(OutputSet outputs);

/// Changes the sign of each value that is a number; zeros have one, too.
inline void negate(std::span<float> values) {
    for (float& value : values) value = std::isnan(value) ? value : -value;
}

/// Makes room for the output of the field's grid.
inline std::span<std::byte> allocate_output(const OutputInfo& info, Field& field) {
    return field.resize(info.output, field.grid.sample_count());
}

}  // namespace clsdf

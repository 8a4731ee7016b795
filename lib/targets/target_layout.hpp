#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include "mesh/input_arrays.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <utility>

/// Where the values of one target lie: types, strides and bytes, with the checks of what a caller gave.
namespace clsdf::targets {

/// Sets the type of a target that leaves it open. Throws Error(unsupported) if the output cannot be written as such
/// numbers.
void resolve_type(const OutputInfo& row, OutputArray& target);

inline std::ptrdiff_t width_of(ElementType type) {
    return static_cast<std::ptrdiff_t>(bytes_of(type));
}

inline bool is_in_double(const OutputArray& target) {
    return target.type == ElementType::float64;
}

/// Sets the strides that are left open; whether the target is packed.
bool resolve_strides(const OutputInfo& row, const Grid& grid, OutputArray& target);

/// Where a target's samples begin and end, in bytes of its memory.
std::pair<double, double> extent_of(const OutputInfo& row, const Grid& grid, const OutputArray& target);

/// Throws Error(invalid_argument) if two values of an array may lie on the same bytes: each stride must be at least the
/// span of all axes with shorter strides. array: "the target of the output distance". width: of a number. All strides
/// are known.
void refuse_values_on_others(const std::string& array, std::ptrdiff_t width, const Index3& size,
                             const std::array<std::ptrdiff_t, 3>& strides, std::size_t components,
                             std::ptrdiff_t component_stride);

/// The bytes of a target's samples. Throws Error(invalid_argument) if they do not lie within `bytes` bytes, unless
/// these are unknown, or not where its numbers can, or if two values may lie on the same bytes.
ByteRange range_of(const OutputInfo& row, const Grid& grid, const OutputArray& target, std::size_t bytes);

}  // namespace clsdf::targets

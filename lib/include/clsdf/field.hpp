#pragma once

#include <clsdf/field_array.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <cstdint>
#include <span>
#include <string>

namespace clsdf {

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

#pragma once

#include <clsdf/field_array.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/topology.hpp>

#include <cstdint>
#include <span>
#include <string>

namespace clsdf {

/// Beyond the band.
inline constexpr std::uint32_t no_triangle = 0xFFFFFFFFU;

/// What a field is to hold beside the distance.
struct Outputs {
    bool triangle = false;  ///< the nearest triangle of every sample in the band
};

/// What a field is, its values apart.
struct FieldDescription {
    Grid grid;
    Band band;
    SignRule sign = SignRule::none;  ///< `automatic` where a file of another program does not say
    std::string mesh_name;
};

/// A computed field on the host. Arrays have grid.sample_count() values, x fastest, and are empty where not asked for;
/// what is made of them by hand is to be set whole, see FieldArray.
struct Field : FieldDescription {
    FieldArray<float> distance;          ///< signed distance in the mesh's units
    FieldArray<std::uint32_t> triangle;  ///< the nearest triangle (caller's order), or no_triangle beyond the band
};

/// The values of some slices of a field, z after z: grid.size[0] * grid.size[1] samples for each, x fastest. An array
/// is empty where the field does not hold that output.
struct FieldSlab {
    std::span<const float> distance{};
    std::span<const std::uint32_t> triangle{};
};

}  // namespace clsdf

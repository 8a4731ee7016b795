#pragma once

#include <clsdf/field.hpp>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace clsdf {

/// The place of a brick's sample in a leaf of a tree: z runs fastest there.
constexpr std::size_t place_in_leaf(std::size_t sample) {
    return 64 * (sample % 8) + 8 * (sample / 8 % 8) + sample / 64;
}

/// The value of samples beyond the band, compared bit by bit: -0.0 is not 0.0. No sample is beyond a band without end.
struct Fill {
    float outside;
    float inside;

    explicit Fill(const Band& band)
        : outside(static_cast<float>(band.outside)), inside(static_cast<float>(band.inside_value())) {}

    static bool is_same(float one, float other) {
        return std::isfinite(one) && std::bit_cast<std::uint32_t>(one) == std::bit_cast<std::uint32_t>(other);
    }
    bool is_outside(float value) const { return is_same(outside, value); }
    bool is_inside(float value) const { return is_same(inside, value); }
    bool is_beyond(float value) const { return is_outside(value) || is_inside(value); }
};

/// OpenVDB's definition of a level set: cubic voxels, a sign, and the half width as background.
inline bool is_level_set(const FieldDescription& field) {
    const Vec3& h = field.grid.spacing;
    return h[0] == h[1] && h[0] == h[2] && std::isfinite(field.band.outside) && field.band.outside > 0 &&
           field.sign != SignRule::none;
}

}  // namespace clsdf

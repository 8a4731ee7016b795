#pragma once

#include <clsdf/field.hpp>

#include <algorithm>
#include <cmath>

namespace clsdf::test {

/// Two balls that overlap, in a band, on a grid with a spacing of its own along each axis. `signed_distance` false:
/// their surfaces alone.
inline Field two_balls(bool signed_distance = true, double band = 0.4) {
    Field field({{{-1.2, -0.9, -0.8}, {0.05, 0.06, 0.08}, {51, 31, 21}, {}},
                 Band::symmetric(band),
                 signed_distance ? SignRule::nonzero : SignRule::none,
                 "folder/two balls.off"});
    for (std::int64_t k = 0; k < field.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < field.grid.size[1]; ++j)
            for (std::int64_t i = 0; i < field.grid.size[0]; ++i) {
                const auto [x, y, z] = field.grid.position(i, j, k);
                double distance = std::min(std::hypot(x + 0.4, y, z) - 0.55, std::hypot(x - 0.45, y, z) - 0.45);
                if (!signed_distance) distance = std::abs(distance);
                field.distance()[field.grid.offset(i, j, k)] = static_cast<float>(std::clamp(distance, -band, band));
            }
    return field;
}

}  // namespace clsdf::test

#pragma once

#include <clsdf/field.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace clsdf::test {

/// A field with the distance that `distance` says, in a band, as DistanceTransform would write it.
inline Field field_of(const Grid& grid, const Band& band, const std::function<double(const Vec3&)>& distance,
                      SignRule sign = SignRule::nonzero) {
    Field field({grid, band, sign, "folder/thing.off"});
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                const double value = distance(grid.position(i, j, k));
                const auto inside = -static_cast<float>(band.inside);
                const auto outside = static_cast<float>(band.outside);
                const auto exact = static_cast<float>(value);
                const bool is_beyond_inside = sign != SignRule::none && value < -band.inside;
                field.distance()[grid.offset(i, j, k)] = is_beyond_inside       ? inside
                                                         : value > band.outside ? outside
                                                                                : exact;
            }
    return field;
}

inline double norm(const Vec3& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// An axis-parallel box around the point 0.
inline double distance_to_box(const Vec3& point, const Vec3& half) {
    Vec3 outside{};
    double inside = -1e300;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double excess = std::abs(point[axis]) - half[axis];
        outside[axis] = std::max(0.0, excess);
        inside = std::max(inside, excess);
    }
    return inside < 0 ? inside : norm(outside);
}

/// 56 x 49 x 41 samples around the ball of radius 1 at 0, at no symmetric place, with a spacing of its own on each
/// axis; the voxel is 0.05.
inline Grid uneven_grid() {
    return {{-1.37, -1.41, -1.45}, {0.05, 0.06, 0.0725}, {56, 49, 41}, {}};
}

}  // namespace clsdf::test

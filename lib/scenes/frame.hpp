#pragma once

#include <clsdf/mesh.hpp>

#include <array>
#include <optional>

namespace clsdf::scenes {

using Rotation = std::array<Vec3, 3>;  ///< by rows

/// The rotation nearest to a matrix, to the rounding of doubles, so that its transpose is its inverse; nothing if an
/// element of the matrix times its transpose differs from the identity's by more than 1e-5, or if the matrix is a
/// reflection. A matrix whose elements are off by no more than the rounding of doubles stays as it is.
std::optional<Rotation> nearest_rotation(const Rotation& matrix);

/// Where a body's own coordinates lie in the scene: at R x + t.
struct Frame {
    Rotation rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3 translation{};
    bool is_turned = false;  ///< the rotation is not the identity

    /// R^T (p - t); exact if R is the identity and t is 0.
    Vec3 to_body(const Vec3& p) const {
        const Vec3 from{p[0] - translation[0], p[1] - translation[1], p[2] - translation[2]};
        if (!is_turned) return from;
        Vec3 result{};
        for (std::size_t a = 0; a < 3; ++a)
            result[a] = from[0] * rotation[0][a] + (from[1] * rotation[1][a] + from[2] * rotation[2][a]);
        return result;
    }
    Vec3 turned(const Vec3& v) const {
        if (!is_turned) return v;
        Vec3 result{};
        for (std::size_t a = 0; a < 3; ++a)
            result[a] = v[0] * rotation[a][0] + (v[1] * rotation[a][1] + v[2] * rotation[a][2]);
        return result;
    }
    Vec3 to_scene(const Vec3& p) const {
        const Vec3 v = turned(p);
        return {v[0] + translation[0], v[1] + translation[1], v[2] + translation[2]};
    }
    /// The smallest boxes along the other axes around a box, widened by more than all rounding of points in it.
    Box to_scene(const Box& box) const;
    Box to_body(const Box& box) const;

    friend bool operator==(const Frame&, const Frame&) = default;
};

/// The distance between a point and a box.
double distance_to(const Box& box, const Vec3& p);

}  // namespace clsdf::scenes

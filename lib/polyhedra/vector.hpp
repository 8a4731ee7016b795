#pragma once

#include <clsdf/box.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace clsdf::polyhedra {

using Vector = Eigen::Vector3d;

inline Vector to_vector(const Vec3& v) {
    return {v[0], v[1], v[2]};
}

/// A unit vector perpendicular to the unit vector `v`.
inline Vector any_perpendicular(const Vector& v) {
    const Vector axis = std::abs(v.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
    return v.cross(axis).normalized();
}

}  // namespace clsdf::polyhedra

#pragma once

#include <clsdf/mesh.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace clsdf::polyhedra {

using Vector = Eigen::Vector3d;

inline Vector to_vector(const Vec3& v) {
    return {v[0], v[1], v[2]};
}

/// A product of two vectors, summed in this order always: frames of triangles come to the same bits whether they are
/// made one by one (triangle_frame.cpp) or many at a time (frame_batch.cpp).
inline double dot(double ax, double ay, double az, double bx, double by, double bz) {
    return ax * bx + ay * by + az * bz;
}
inline double dot(const Vector& a, const Vector& b) {
    return dot(a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
}

/// A unit vector perpendicular to the unit vector `v`.
inline Vector any_perpendicular(const Vector& v) {
    const Vector axis = std::abs(v.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
    return v.cross(axis).normalized();
}

}  // namespace clsdf::polyhedra

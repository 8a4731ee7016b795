#pragma once

#include <clsdf/mesh.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>

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

/// A vector of numbers, as wide as the processor's vectors.
constexpr std::size_t lanes = 8;

using Lanes = std::array<double, lanes>;

struct LaneVectors {
    Lanes x;
    Lanes y;
    Lanes z;

    /// For vectors of any kind.
    template <typename V>
    void set(std::size_t i, const V& v) {
        x[i] = v[0];
        y[i] = v[1];
        z[i] = v[2];
    }
    Vector get(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

inline double dot_of_lane(const LaneVectors& a, const LaneVectors& b, std::size_t i) {
    return dot(a.x[i], a.y[i], a.z[i], b.x[i], b.y[i], b.z[i]);
}

}  // namespace clsdf::polyhedra

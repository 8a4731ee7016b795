#pragma once

#include <clsdf/mesh.hpp>

#include <cmath>

namespace clsdf {

inline double dot(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Vec3 difference(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double length(const Vec3& a) {
    return std::sqrt(dot(a, a));
}

inline Vec3 normalized(const Vec3& a) {
    const double size = length(a);
    return {a[0] / size, a[1] / size, a[2] / size};
}

}  // namespace clsdf

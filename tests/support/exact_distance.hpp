#pragma once

#include <clsdf/mesh.hpp>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <array>

/// Distances in rational arithmetic: no rounding before the last square root.
namespace clsdf::test {

using Rational = boost::multiprecision::cpp_rational;
using RationalPoint = std::array<Rational, 3>;

inline RationalPoint rational(const Vec3& point) {
    return {Rational(point[0]), Rational(point[1]), Rational(point[2])};
}

inline RationalPoint minus(const RationalPoint& a, const RationalPoint& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Rational dot(const RationalPoint& a, const RationalPoint& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline RationalPoint cross(const RationalPoint& a, const RationalPoint& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Rational squared_distance_to_segment(const RationalPoint& y, const RationalPoint& a, const RationalPoint& b) {
    const RationalPoint along = minus(b, a);
    const RationalPoint from = minus(y, a);
    const Rational length = dot(along, along);
    const Rational reached = dot(from, along);
    if (reached <= 0) {
        return dot(from, from);
    }
    if (reached >= length) {
        return dot(minus(y, b), minus(y, b));
    }
    return dot(from, from) - reached * reached / length;
}

inline Rational squared_distance_to_triangle(const RationalPoint& y, const RationalPoint& a, const RationalPoint& b,
                                             const RationalPoint& c) {
    const RationalPoint normal = cross(minus(b, a), minus(c, a));
    const Rational area = dot(normal, normal);
    const auto is_within = [&](const RationalPoint& from, const RationalPoint& to) {
        return dot(cross(minus(to, from), minus(y, from)), normal) >= 0;
    };
    if (area > 0 && is_within(a, b) && is_within(b, c) && is_within(c, a)) {
        const Rational height = dot(minus(y, a), normal);
        return height * height / area;
    }
    return std::min({squared_distance_to_segment(y, a, b), squared_distance_to_segment(y, b, c),
                     squared_distance_to_segment(y, c, a)});
}

inline long double exact_distance(const Vec3& y, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Rational squared = squared_distance_to_triangle(rational(y), rational(a), rational(b), rational(c));
    using Wide = boost::multiprecision::cpp_bin_float_50;  // its exponents hold the squares of the smallest doubles
    return Wide(sqrt(squared.convert_to<Wide>())).convert_to<long double>();
}

}  // namespace clsdf::test

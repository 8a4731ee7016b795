#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

/// The rule of segments (docs/method.md, 'Segments') in whole numbers of any size: each segment is looked at eight
/// times, moved by (+-e, +-e^2, +-e^3). All faces of the mesh count once.
namespace clsdf::test {

using Integer = boost::multiprecision::cpp_int;
using IntegerPoint = std::array<Integer, 3>;

inline IntegerPoint minus(const IntegerPoint& a, const IntegerPoint& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Integer dot(const IntegerPoint& a, const IntegerPoint& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline IntegerPoint cross(const IntegerPoint& a, const IntegerPoint& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline int sign_of(const Integer& x) {
    return x.sign();
}

/// Multiples of 2^exponent.
inline Integer in_multiples(double x, int exponent) {
    if (x == 0) return 0;
    int of_x = 0;
    auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &of_x), 53));
    of_x -= 53;
    for (; of_x < exponent; ++of_x) mantissa /= 2;
    return Integer(mantissa) << (of_x - exponent);
}
/// That x is a multiple of.
inline int exponent_of(double x) {
    if (x == 0) return std::numeric_limits<int>::max();
    int exponent = 0;
    auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    for (exponent -= 53; mantissa % 2 == 0; mantissa /= 2) ++exponent;
    return exponent;
}

/// numerator / denominator, which is positive.
struct Fraction {
    Integer numerator, denominator;

    friend int compare(const Fraction& a, const Fraction& b) {
        return sign_of(a.numerator * b.denominator - b.numerator * a.denominator);
    }
    /// How far a double is off, in units of its last place.
    double ulps_from(double x) const {
        using Real = boost::multiprecision::cpp_bin_float_100;
        const Real exact = Real(numerator) / Real(denominator);
        const double ulp = std::nextafter(std::abs(x), std::numeric_limits<double>::infinity()) - std::abs(x);
        return static_cast<double>(abs(Real(x) - exact) / Real(ulp));
    }
};

struct JudgedWall {
    Fraction place;
    std::uint32_t triangle;
    bool enters;
};

using LookWindings = std::array<int, 8>;

class SegmentJudge {
public:
    SegmentJudge(const Mesh& mesh, SignRule rule, const std::array<std::vector<double>, 3>& samples) : rule_(rule) {
        exponent_ = std::numeric_limits<int>::max();
        const auto look_at = [&](double x) { exponent_ = std::min(exponent_, exponent_of(x)); };
        for (const Vec3& v : mesh.vertices())
            for (const double x : v) look_at(x);
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const double x : samples[axis]) look_at(x);
        for (const Triangle& t : mesh.triangles()) {
            Face face{{point(mesh.vertices()[t[0]]), point(mesh.vertices()[t[1]]), point(mesh.vertices()[t[2]])},
                      {},
                      mesh.vertices()[t[0]],
                      mesh.vertices()[t[0]]};
            face.normal = cross(minus(face.corners[1], face.corners[0]), minus(face.corners[2], face.corners[0]));
            for (const std::uint32_t v : t)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    face.low[axis] = std::min(face.low[axis], mesh.vertices()[v][axis]);
                    face.high[axis] = std::max(face.high[axis], mesh.vertices()[v][axis]);
                }
            faces_.push_back(face);
        }
        low_ = mesh.box().lower[0];
    }

    /// By a ray towards -x.
    LookWindings windings(const Vec3& p) const {
        LookWindings windings{};
        if (p[0] < low_) return windings;
        Vec3 begin = p;
        begin[0] = low_ - std::max(1.0, std::abs(low_));
        for (const Crossing& c : crossings(begin, p)) windings[c.look] += c.change;
        return windings;
    }
    bool is_inside(const LookWindings& windings) const {
        return std::ranges::all_of(windings, [&](int w) { return rule_ == SignRule::parity ? w % 2 != 0 : w != 0; });
    }

    std::vector<JudgedWall> walls(const Vec3& p, const Vec3& q, LookWindings windings) const {
        std::vector<JudgedWall> walls;
        bool state = is_inside(windings);
        const std::vector<Crossing> all = crossings(p, q);
        for (std::size_t i = 0; i < all.size();) {
            const Fraction place = all[i].place;
            std::uint32_t lowest = all[i].face;
            for (; i < all.size() && compare(all[i].place, place) == 0; ++i) {
                windings[all[i].look] += all[i].change;
                lowest = std::min(lowest, all[i].face);
            }
            if (is_inside(windings) == state) continue;
            state = !state;
            walls.push_back({place, lowest, state});
        }
        return walls;
    }

private:
    struct Face {
        std::array<IntegerPoint, 3> corners;
        IntegerPoint normal;
        Vec3 low, high;
    };
    struct Crossing {
        Fraction place;
        std::size_t look;
        int change;
        std::uint32_t face;
    };

    IntegerPoint point(const Vec3& p) const {
        if (exponent_ == std::numeric_limits<int>::max()) return {};
        return {in_multiples(p[0], exponent_), in_multiples(p[1], exponent_), in_multiples(p[2], exponent_)};
    }
    /// Of v (+-e, +-e^2, +-e^3).
    static int moved_sign(const IntegerPoint& v, std::size_t look) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (const int sign = sign_of(v[axis])) return (look >> axis & 1U) != 0 ? -sign : sign;
        return 0;
    }

    /// Sorted by place.
    std::vector<Crossing> crossings(const Vec3& begin, const Vec3& end) const {
        std::vector<Crossing> found;
        const IntegerPoint p = point(begin), q = point(end), along = minus(q, p);
        for (std::uint32_t number = 0; number < faces_.size(); ++number) {
            const Face& face = faces_[number];
            bool is_apart = false;
            for (std::size_t axis = 0; axis < 3; ++axis)
                is_apart = is_apart || face.low[axis] > std::max(begin[axis], end[axis]) ||
                           face.high[axis] < std::min(begin[axis], end[axis]);
            if (is_apart || face.normal == IntegerPoint{}) continue;
            const Integer from_p = dot(face.normal, minus(p, face.corners[0])),
                          from_q = dot(face.normal, minus(q, face.corners[0]));
            if (from_p == from_q) continue;
            std::array<Integer, 3> turns;
            std::array<IntegerPoint, 3> by_move;
            for (std::size_t i = 0; i < 3; ++i) {
                const IntegerPoint &a = face.corners[i], &b = face.corners[(i + 1) % 3];
                turns[i] = dot(along, cross(minus(a, p), minus(b, p)));
                by_move[i] = cross(along, minus(b, a));
            }
            Fraction place{from_p, from_p - from_q};
            if (place.denominator < 0) place = {-place.numerator, -place.denominator};
            for (std::size_t look = 0; look < 8; ++look) {
                const int tie = moved_sign(face.normal, look);
                const int side_p = from_p == 0 ? tie : sign_of(from_p), side_q = from_q == 0 ? tie : sign_of(from_q);
                if (side_p == side_q) continue;
                std::array<int, 3> signs{};
                for (std::size_t i = 0; i < 3; ++i)
                    signs[i] = turns[i] == 0 ? moved_sign(by_move[i], look) : sign_of(turns[i]);
                if (signs[0] == signs[1] && signs[1] == signs[2]) found.push_back({place, look, side_p, number});
            }
        }
        std::ranges::stable_sort(found,
                                 [](const Crossing& a, const Crossing& b) { return compare(a.place, b.place) < 0; });
        return found;
    }

    SignRule rule_;
    int exponent_;
    double low_ = 0;
    std::vector<Face> faces_;
};

}  // namespace clsdf::test

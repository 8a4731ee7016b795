#include "conformance/set.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/mesh_files.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

// The second program of the conformance set: every answer again, by looking at all triangles in sums of two doubles. It
// shares nothing with conformance/exact.py, and nothing with the library but the reader of .obj files.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The unevaluated sum of two doubles (T. J. Dekker, 1971): about 32 digits.
struct Twofold {
    double high = 0, low = 0;

    Twofold(double value = 0) : high(value) {}
    Twofold(double a, double b) : high(a + b), low(b - (high - a)) {}  // |a| >= |b|

    friend Twofold operator+(const Twofold& a, const Twofold& b) {
        const double sum = a.high + b.high, part = sum - a.high;
        const double rest = (a.high - (sum - part)) + (b.high - part);
        const double lows = a.low + b.low, low_part = lows - a.low;
        const double low_rest = (a.low - (lows - low_part)) + (b.low - low_part);
        const Twofold first(sum, rest + lows);
        return {first.high, first.low + low_rest};
    }
    Twofold operator-() const {
        Twofold negative;
        negative.high = -high;
        negative.low = -low;
        return negative;
    }
    friend Twofold operator-(const Twofold& a, const Twofold& b) { return a + -b; }
    friend Twofold operator*(const Twofold& a, const Twofold& b) {
        const double product = a.high * b.high;
        return {product, std::fma(a.high, b.high, -product) + (a.high * b.low + a.low * b.high)};
    }
    friend Twofold operator/(const Twofold& a, const Twofold& b) {
        const double first = a.high / b.high;
        const Twofold rest = a - b * Twofold(first);
        const double second = rest.high / b.high;
        const Twofold last = rest - b * Twofold(second);
        return Twofold(first, second) + Twofold(last.high / b.high);
    }
    friend bool operator<(const Twofold& a, const Twofold& b) { return (a - b).high < 0; }
    friend Twofold root(const Twofold& a) {
        if (a.high <= 0) return 0;
        const double first = std::sqrt(a.high);
        const Twofold rest = a - Twofold(first) * Twofold(first);
        return Twofold(first, rest.high / (2 * first));
    }
    long double wide() const { return static_cast<long double>(high) + static_cast<long double>(low); }
};

using Vector = std::array<Twofold, 3>;

Vector vector(const Vec3& v) {
    return {v[0], v[1], v[2]};
}
Vector operator-(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector scaled(const Vector& a, const Twofold& factor) {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}
Twofold dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// Squares of lengths below 1e-154 would vanish.
Twofold length(const Vector& a) {
    double largest = 0;
    for (const Twofold& x : a) largest = std::max(largest, std::fabs(x.high));
    if (largest == 0) return 0;
    const double unit = std::ldexp(1.0, std::ilogb(largest));
    const Vector part = scaled(a, Twofold(1 / unit));
    return root(dot(part, part)) * Twofold(unit);
}

using Corners = std::array<Vector, 3>;

/// From the closest point of a triangle to the point.
Vector offset_from(const Corners& corners, const Vector& point) {
    Vector best = point - corners[0];
    const auto take = [&](const Vector& offset) {
        if (length(offset) < length(best)) best = offset;
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector along = corners[(k + 1) % 3] - corners[k], from = point - corners[k];
        const Twofold square = dot(along, along), way = dot(along, from);
        take(from);
        if (Twofold(0) < way && way < square) take(from - scaled(along, way / square));
    }
    const Vector normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    const Twofold square = dot(normal, normal);
    if (!(Twofold(0) < square)) return best;
    for (std::size_t k = 0; k < 3; ++k)
        if (dot(cross(corners[(k + 1) % 3] - corners[k], point - corners[k]), normal) < Twofold(0)) return best;
    take(scaled(normal, dot(point - corners[0], normal) / square));
    return best;
}

/// The solid angle of a triangle (A. van Oosterom and J. Strackee, 1983); the determinant, which decides, is exact.
long double solid_angle(const Corners& corners, const Vector& point) {
    const Vector a = corners[0] - point, b = corners[1] - point, c = corners[2] - point;
    const Twofold la = length(a), lb = length(b), lc = length(c);
    const Twofold volume = dot(a, cross(b, c));
    const Twofold rest = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return 2 * std::atan2(volume.wide(), rest.wide());
}

/// With faces to be mended, those of the same three places count once.
std::vector<Corners> triangles_that_decide(const Mesh& mesh, bool once) {
    std::vector<Corners> result;
    std::set<std::array<Vec3, 3>> seen;
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<Vec3, 3> places{};
        for (std::size_t k = 0; k < 3; ++k) places[k] = mesh.vertices()[triangle[k]];
        const Corners corners{vector(places[0]), vector(places[1]), vector(places[2])};
        std::ranges::sort(places);
        if (!once || seen.insert(places).second) result.push_back(corners);
    }
    return result;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_second_program_agrees_with_every_answer) {
    const std::vector<ConformanceCase> cases = conformance_cases(CLSDF_CONFORMANCE_SET);
    BOOST_TEST(cases.size() >= 60);
    for (const ConformanceCase& one : cases) {
        const Mesh mesh = read_mesh((one.folder / "mesh.obj").string());
        const std::vector<Vec3> points = read_points((one.folder / "points.npy").string());
        BOOST_TEST(read_points((one.folder / "points.csv").string()) == points);
        const std::vector<Corners> all = triangles_that_decide(mesh, false);
        const std::vector<Corners> deciding = triangles_that_decide(mesh, one.asks("repair"));
        const double tolerance = one.answers["tolerance"];
        BOOST_REQUIRE(one.answers["distance"].size() == points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto about = [&] { return one.name() + ", point " + std::to_string(i); };
            const Vector point = vector(points[i]);
            std::vector<double> distances;
            for (const Corners& corners : all) distances.push_back(length(offset_from(corners, point)).high);
            const double least = *std::ranges::min_element(distances);
            double largest = 0;
            for (const double x : points[i]) largest = std::max(largest, std::fabs(x));
            const double rounding = 3e-16 * least + 1e-28 * largest;
            const double answer = one.answers["distance"][i];
            BOOST_TEST(std::fabs(answer - least) <= rounding, about() << ": " << answer << " is not " << least);

            std::set<std::uint32_t> allowed;
            for (const std::uint32_t triangle : one.answers["triangle"][i]) allowed.insert(triangle);
            for (std::uint32_t triangle = 0; triangle < all.size(); ++triangle) {
                const double more = distances[triangle] - least;
                if (std::fabs(more - tolerance) <= 1e-6 * tolerance + 2 * rounding) continue;
                BOOST_TEST(allowed.contains(triangle) == (more <= tolerance), about() << ", triangle " << triangle);
            }

            // Each place is on one of these triangles, at its distance, and each triangle has one.
            for (const std::uint32_t triangle : allowed) {
                double off = std::numeric_limits<double>::infinity();
                const Vector offset = offset_from(all[triangle], point);
                for (const Vec3 place : one.answers["closest"][i])
                    off = std::min(off, length((point - offset) - vector(place)).high);
                BOOST_TEST(off <= 4e-16 * (largest + least), about() << ", triangle " << triangle << ": " << off);
            }
            BOOST_TEST(one.answers["closest"][i].size() <= allowed.size());

            const int sign = one.answers["sign"][i];
            if (one.asks("no sign") || answer == 0) {
                BOOST_TEST(sign == 0, about());
                continue;
            }
            long double angles = 0;
            for (const Corners& corners : deciding) angles += solid_angle(corners, point);
            const auto winding = static_cast<double>(angles / (4 * std::numbers::pi_v<long double>));
            BOOST_TEST(sign == (std::fabs(winding) >= 0.5 ? -1 : 1), about() << ": winding number " << winding);
            if (!one.asks("repair") && !one.asks("open"))
                BOOST_TEST(std::fabs(winding - std::round(winding)) < 1e-9, about() << ": winding number " << winding);
            if (one.asks("open"))
                BOOST_TEST(std::fabs(winding - one.answers["winding"][i].get<double>()) < 1e-14, about());
        }
    }
}

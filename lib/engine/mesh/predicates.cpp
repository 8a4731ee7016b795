#include "mesh/predicates.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/MP_Float.h>

#include <cmath>
#include <optional>

#ifdef __FAST_MATH__
#error "exact predicates need the arithmetic of IEEE 754: compile without -ffast-math"
#endif

namespace clsdf {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Vec3& p) {
    return {p[0], p[1], p[2]};
}

Kernel::Point_2 point(const std::array<double, 2>& p) {
    return {p[0], p[1]};
}

using Exact = CGAL::MP_Float;
using ExactVector = std::array<Exact, 3>;

ExactVector difference(const Vec3& a, const Vec3& b) {
    return {Exact(a[0]) - Exact(b[0]), Exact(a[1]) - Exact(b[1]), Exact(a[2]) - Exact(b[2])};
}

ExactVector cross(const ExactVector& a, const ExactVector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Exact dot(const ExactVector& a, const ExactVector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Whether the difference, as it is rounded, is exact.
bool is_exact_difference(double a, double b, double difference) {
    const double subtracted = a - difference;
    return (a - (difference + subtracted)) + (subtracted - b) == 0;
}

/// The sign of a d - b c; nothing if a product is too large or too small.
std::optional<int> sign_of_determinant(double a, double b, double c, double d) {
    const double left = a * d, right = b * c;
    if (left != right) return left > right ? 1 : left < right ? -1 : std::optional<int>();
    if ((a == 0 || d == 0) && (b == 0 || c == 0)) return 0;
    if (!(std::abs(left) > 0x1p-900) || !std::isfinite(left)) return std::nullopt;
    const double left_rest = std::fma(a, d, -left), right_rest = std::fma(b, c, -right);
    return left_rest > right_rest ? 1 : left_rest < right_rest ? -1 : 0;
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return static_cast<int>(CGAL::orientation(point(a), point(b), point(c), point(d)));
}

int orientation(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c) {
    // Corners of a lattice or of an axis-aligned box are often on a line, where CGAL's predicate takes longest.
    const double abx = b[0] - a[0], aby = b[1] - a[1], acx = c[0] - a[0], acy = c[1] - a[1];
    if (is_exact_difference(b[0], a[0], abx) && is_exact_difference(b[1], a[1], aby) &&
        is_exact_difference(c[0], a[0], acx) && is_exact_difference(c[1], a[1], acy))
        if (const std::optional<int> sign = sign_of_determinant(abx, aby, acx, acy)) return *sign;
    return static_cast<int>(CGAL::orientation(point(a), point(b), point(c)));
}

bool are_collinear(const Vec3& a, const Vec3& b, const Vec3& c) {
    return CGAL::collinear(point(a), point(b), point(c));
}

int compare_places(const std::array<Vec3, 3>& first, const std::array<Vec3, 3>& second, const Vec3& from,
                   const Vec3& to, const Vec3& origin) {
    const ExactVector along = difference(to, origin);
    // The place is distance / approach.
    const auto fraction = [&](const std::array<Vec3, 3>& face) {
        const ExactVector normal = cross(difference(face[1], face[0]), difference(face[2], face[0]));
        return std::array<Exact, 2>{dot(normal, difference(face[0], from)), dot(normal, along)};
    };
    const auto [first_distance, first_approach] = fraction(first);
    const auto [second_distance, second_approach] = fraction(second);
    const auto order = CGAL::sign(first_distance * second_approach - second_distance * first_approach);
    return static_cast<int>(order) * static_cast<int>(CGAL::sign(first_approach)) *
           static_cast<int>(CGAL::sign(second_approach));
}

}  // namespace clsdf

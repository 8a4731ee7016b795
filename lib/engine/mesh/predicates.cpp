#include "mesh/predicates.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/MP_Float.h>

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

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return static_cast<int>(CGAL::orientation(point(a), point(b), point(c), point(d)));
}

int orientation(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c) {
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

#include "mesh/predicates.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

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

}  // namespace clsdf

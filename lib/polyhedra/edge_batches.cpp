#include "polyhedra/edge_batches.hpp"

#include "core/several_targets.hpp"
#include "polyhedra/lateral_planes.hpp"

#include <cmath>

#ifdef __FAST_MATH__
#error "exact predicates need the arithmetic of IEEE 754: compile without -ffast-math"
#endif

namespace clsdf::polyhedra {

CLSDF_SEVERAL_TARGETS void WedgeBatch::measure(Results& results) const {
    const auto& [first_x, first_y, first_z] = first_;
    const auto& [second_x, second_y, second_z] = second_;
    for (std::size_t i = 0; i < capacity; ++i) {
        const double sine = second_x[i] * normal_[0][i] + second_y[i] * normal_[1][i] + second_z[i] * normal_[2][i];
        const double x = first_x[i] - second_x[i];
        const double y = first_y[i] - second_y[i];
        const double z = first_z[i] - second_z[i];
        const double squared_apart = x * x + y * y + z * z;
        const double u = first_x[i] + second_x[i];
        const double v = first_y[i] + second_y[i];
        const double w = first_z[i] + second_z[i];
        // Folded pairs must not divide by zero: programs may trap that.
        const double divisor = squared_apart > 0 ? squared_apart : 1;
        results.slope[i] = widened(std::sqrt(u * u + v * v + w * w) / std::sqrt(divisor));
        results.folded[i] = folded(squared_apart) ? 1 : 0;
        const double turn = folded(squared_apart) ? 2 : turn_[i];
        results.side[i] = (sine > turn ? 1 : 0) - (sine < -turn ? 1 : 0);
    }
}

namespace {

/// The sum of two numbers, the second at most a rounding of the first (Dekker's double-length arithmetic). Differences
/// of coordinates are exact. The others err by a few 2^-104 of the magnitudes that enter them.
struct Double2 {
    double high;
    double low;
};

inline Double2 exact_sum(double a, double b) {
    const double sum = a + b;
    const double of_b = sum - a;
    return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// For |low| no greater than a few roundings of `high`.
inline Double2 carried(double high, double low) {
    const double sum = high + low;
    return {sum, low - (sum - high)};
}

/// The upper half of a number's digits.
inline double upper_half(double x) {
    const double shifted = 134217729 * x;  // 2^27 + 1
    return shifted - (shifted - x);
}

inline Double2 product(const Double2& a, const Double2& b) {
    const double high = a.high * b.high;
    const double a_upper = upper_half(a.high);
    const double b_upper = upper_half(b.high);
    const double a_lower = a.high - a_upper;
    const double b_lower = b.high - b_upper;
    const double rounding = ((a_upper * b_upper - high) + a_upper * b_lower + a_lower * b_upper) + a_lower * b_lower;
    return carried(high, rounding + (a.high * b.low + a.low * b.high));
}

inline Double2 sum(const Double2& a, const Double2& b) {
    const Double2 high = exact_sum(a.high, b.high);
    return carried(high.high, high.low + (a.low + b.low));
}

inline Double2 difference(const Double2& a, const Double2& b) {
    return sum(a, {-b.high, -b.low});
}

}  // namespace

void PlaneSides::set(std::size_t i, const OppositeVertex& vertex) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t corner = 0; corner < 3; ++corner) points_[corner][axis][i] = vertex.plane[corner][axis];
        points_[3][axis][i] = vertex.point[axis];
    }
}

// A determinant's roundings are fewer than fifty of 2^-104 of its permanent, less than 2^-98 of it. Where products
// leave the range of double at its lower end, each loses at most 2^-1074 more, times a length; at the upper end nothing
// is certain, because comparisons with infinity and with what is no number fail.
CLSDF_SEVERAL_TARGETS void PlaneSides::measure(Sides& sides) const {
    constexpr double roundings = 0x1p-98;
    constexpr double underflow = 1e-300;
    const auto& [p, q, r, s] = points_;
    for (std::size_t i = 0; i < capacity; ++i) {
        const Double2 ax = exact_sum(q[0][i], -p[0][i]);
        const Double2 ay = exact_sum(q[1][i], -p[1][i]);
        const Double2 az = exact_sum(q[2][i], -p[2][i]);
        const Double2 bx = exact_sum(r[0][i], -p[0][i]);
        const Double2 by = exact_sum(r[1][i], -p[1][i]);
        const Double2 bz = exact_sum(r[2][i], -p[2][i]);
        const Double2 cx = exact_sum(s[0][i], -p[0][i]);
        const Double2 cy = exact_sum(s[1][i], -p[1][i]);
        const Double2 cz = exact_sum(s[2][i], -p[2][i]);

        const Double2 x = product(cx, difference(product(ay, bz), product(az, by)));
        const Double2 y = product(cy, difference(product(az, bx), product(ax, bz)));
        const Double2 z = product(cz, difference(product(ax, by), product(ay, bx)));
        const double determinant = sum(sum(x, y), z).high;

        const double of_x = std::abs(cx.high);
        const double of_y = std::abs(cy.high);
        const double of_z = std::abs(cz.high);
        const double permanent = of_x * (std::abs(ay.high * bz.high) + std::abs(az.high * by.high)) +
                                 of_y * (std::abs(az.high * bx.high) + std::abs(ax.high * bz.high)) +
                                 of_z * (std::abs(ax.high * by.high) + std::abs(ay.high * bx.high));
        const double bound = roundings * permanent + underflow * (1 + of_x + of_y + of_z);
        sides[i] = (determinant > bound ? 1 : 0) - (-determinant > bound ? 1 : 0);
    }
}

}  // namespace clsdf::polyhedra

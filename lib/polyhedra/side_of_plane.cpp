#include "polyhedra/side_of_plane.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <optional>

#ifdef __FAST_MATH__
#error "exact predicates need the arithmetic of IEEE 754: compile without -ffast-math"
#endif

namespace clsdf::polyhedra {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Vec3& v) {
    return {v[0], v[1], v[2]};
}

#ifdef __SIZEOF_INT128__

__extension__ using Integer = __int128;
using Integers = std::array<std::int64_t, 3>;

/// Differences of coordinates, where a power of two makes all of them integers below 2^59: so it does those of a mesh's
/// neighbouring vertices, except where a coordinate is near 0, whose last digit is far smaller then. That a difference
/// is exact is told by adding and subtracting it again: its error would be a multiple of the last digit of the smaller
/// number.
class IntegerDifferences {
public:
    explicit IntegerDifferences(const OppositeVertex& vertex) {
        const auto& [a, b, c] = vertex.plane;
        add(a, b, 0);
        add(a, c, 1);
        add(a, vertex.point, 2);
    }

    std::optional<std::array<Integers, 3>> integers() const {
        const double scale = std::ldexp(1.0, 58 - std::ilogb(std::max(largest_, 1e-200)));
        std::array<Integers, 3> result{};
        bool are_whole = are_exact_ && largest_ < 1e200;
        for (std::size_t i = 0; i < 9 && are_whole; ++i) {
            const double scaled = differences_[i] * scale;
            result[i / 3][i % 3] = static_cast<std::int64_t>(scaled);
            // What is far smaller than the largest difference may have become 0.
            are_whole = static_cast<double>(result[i / 3][i % 3]) == scaled && (scaled != 0) == (differences_[i] != 0);
        }
        return are_whole ? std::optional(result) : std::nullopt;
    }

private:
    void add(const Vec3& from, const Vec3& to, std::size_t i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double difference = to[axis] - from[axis];
            const double of_from = to[axis] - difference;
            are_exact_ = are_exact_ && of_from == from[axis] && difference + of_from == to[axis];
            largest_ = std::max(largest_, std::abs(difference));
            differences_[3 * i + axis] = difference;
        }
    }

    std::array<double, 9> differences_{};
    double largest_ = 0;
    bool are_exact_ = true;
};

Integer minor(const Integers& a, const Integers& b, std::size_t i, std::size_t j) {
    return static_cast<Integer>(a[i]) * b[j] - static_cast<Integer>(a[j]) * b[i];
}

int sign_of_determinant(const std::array<Integers, 3>& vectors) {
    const auto& [a, b, c] = vectors;
    const std::array<Integer, 3> minors{minor(a, b, 1, 2), minor(a, b, 2, 0), minor(a, b, 0, 1)};
    // The determinant is upper * 2^64 + lower.
    Integer upper = 0;
    Integer lower = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        upper += (minors[i] >> 64) * c[i];
        lower += static_cast<Integer>(static_cast<std::uint64_t>(minors[i])) * c[i];
    }
    upper += lower >> 64;
    if (upper != 0) return upper > 0 ? 1 : -1;
    return static_cast<std::uint64_t>(lower) != 0 ? 1 : 0;
}

#endif

}  // namespace

int side_of_plane(const OppositeVertex& vertex) {
#ifdef __SIZEOF_INT128__
    if (const auto vectors = IntegerDifferences(vertex).integers()) return sign_of_determinant(*vectors);
#endif
    const auto& [a, b, c] = vertex.plane;
    return static_cast<int>(CGAL::orientation(point(a), point(b), point(c), point(vertex.point)));
}

}  // namespace clsdf::polyhedra

#include "scenes/frame.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::scenes {

namespace {

double determinant(const Rotation& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Above the rounding of points, relative to the coordinates that they are made of.
constexpr double rounding = 1e-14;

/// map(corner): of the box.
template <typename Map>
Box around(const Box& box, double largest, const Map& map) {
    Box result;
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = (corner >> axis & 1U) != 0 ? box.upper[axis] : box.lower[axis];
        p = map(p);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            result.lower[axis] = corner == 0 ? p[axis] : std::min(result.lower[axis], p[axis]);
            result.upper[axis] = corner == 0 ? p[axis] : std::max(result.upper[axis], p[axis]);
        }
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(result.lower[axis]), std::abs(result.upper[axis])});
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.lower[axis] -= rounding * largest;
        result.upper[axis] += rounding * largest;
    }
    return result;
}

double largest_of(const Box& box, const Vec3& translation) {
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest =
            std::max({largest, std::abs(box.lower[axis]), std::abs(box.upper[axis]), std::abs(translation[axis])});
    return largest;
}

}  // namespace

std::optional<Rotation> nearest_rotation(const Rotation& matrix) {
    constexpr double rounded_to_floats = 1e-5, rounded_to_doubles = 8e-16;
    double error = 0;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) {
            const double product =
                matrix[a][0] * matrix[b][0] + matrix[a][1] * matrix[b][1] + matrix[a][2] * matrix[b][2];
            const double of_product = std::abs(product - (a == b ? 1 : 0));
            if (!(of_product <= rounded_to_floats)) return std::nullopt;
            error = std::max(error, of_product);
        }
    if (!(determinant(matrix) > 0)) return std::nullopt;
    if (error <= rounded_to_doubles) return matrix;
    // Newton's iteration X <- (X + X^-T) / 2 for the polar decomposition (Higham 1986): errors 1e-5, 1e-10, 1e-20.
    Rotation x = matrix;
    for (int step = 0; step < 3; ++step) {
        const double scale = 1 / determinant(x);
        Rotation next;
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b) {
                const std::size_t i = (a + 1) % 3, j = (a + 2) % 3, k = (b + 1) % 3, l = (b + 2) % 3;
                const double cofactor = x[i][k] * x[j][l] - x[i][l] * x[j][k];
                next[a][b] = (x[a][b] + cofactor * scale) / 2;
            }
        x = next;
    }
    return x;
}

Box Frame::to_scene(const Box& box) const {
    return around(box, largest_of(box, translation), [&](const Vec3& p) { return to_scene(p); });
}

Box Frame::to_body(const Box& box) const {
    return around(box, largest_of(box, translation), [&](const Vec3& p) { return to_body(p); });
}

double distance_to(const Box& box, const Vec3& p) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double apart = std::max({box.lower[axis] - p[axis], p[axis] - box.upper[axis], 0.0});
        squared += apart * apart;
    }
    return std::sqrt(squared);
}

}  // namespace clsdf::scenes

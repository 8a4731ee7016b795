#pragma once

#include <clsdf/mesh.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

/// The turns of a piece of film, seen from afar, as a multipole expansion: a sum of harmonic polynomials H_k(r) /
/// |r|^(2k + 1), r from the point to a centre of the piece (docs/method.md, 'Sign of open meshes').
namespace clsdf {

/// The expansion has the terms of the degrees 1 to this.
constexpr std::size_t film_degree = 5;
/// Of x, y and z up to that degree: ascending by degree, then by the power of x, then by that of z.
constexpr std::size_t film_monomials = (film_degree + 1) * (film_degree + 2) * (film_degree + 3) / 6;
/// Only pieces whose radius is at most so many times their distance are expanded.
constexpr double film_reach = 0.6;

/// The integrals of n.grad(y^a / a!) over a film for the monomials y^a, y from a centre.
class FilmMoments {
public:
    /// A triangle with these corners, from the centre. normal: its area vector.
    void add_triangle(const Vec3& normal, const std::array<Vec3, 3>& corners);
    /// The moments of another film, from whose centre this one's lies at -shift.
    void add_shifted(const FilmMoments& other, const Vec3& shift);

    const std::array<double, film_monomials>& all() const { return moments_; }

private:
    std::array<double, film_monomials> moments_{};
};

/// The coefficients of the polynomials, that of degree 0 left out.
class FilmExpansion {
public:
    explicit FilmExpansion(const FilmMoments& moments);

    /// The turns at points of `rows` rows along x. r: from the first point to the centre. y: the same of each row.
    /// step: from one point to the next.
    template <std::size_t rows, std::size_t count>
    [[gnu::always_inline]] std::array<std::array<double, count>, rows> at(const Vec3& r,
                                                                          const std::array<double, rows>& y,
                                                                          double step) const;
    double at(const Vec3& r) const { return at<1, 1>(r, {r[1]}, 0)[0][0]; }

private:
    std::array<double, film_monomials - 1> coefficients_;
};

/// The expansion is off by at most that at a distance from the centre. radius: of a ball around the centre that the
/// film is in. spread: the integral of |y|^film_degree over the film, or more. Infinite if the film is too near.
inline double film_expansion_error(double radius, double spread, double distance) {
    // |y|^k P_k has a gradient of at most k |y|^(k - 1), so the term of degree k is at most the integral of that over
    // distance^(k + 1).
    if (!(radius <= film_reach * distance && distance > 0x1p-64)) return std::numeric_limits<double>::infinity();
    const double q = radius / distance, square = distance * distance;
    return 0.25 * std::numbers::inv_pi * spread * ((film_degree + 1) - film_degree * q) /
           ((1 - q) * (1 - q) * (square * square * square * distance));
}

// Loops of known length, which compilers unroll: so the coefficients are operands of vector instructions.
template <std::size_t rows, std::size_t count>
inline std::array<std::array<double, count>, rows> FilmExpansion::at(const Vec3& r, const std::array<double, rows>& y,
                                                                     double step) const {
    constexpr std::size_t powers = film_degree + 1;
    // y^b z^c for b + c = 0, 1, ..., by c.
    std::array<std::array<double, rows>, powers*(powers + 1) / 2> across;
    across[0].fill(1);
#pragma GCC unroll 8
    for (std::size_t degree = 1; degree < powers; ++degree) {
        const std::size_t begin = degree * (degree + 1) / 2;
#pragma GCC unroll 8
        for (std::size_t c = 0; c < degree; ++c)
            for (std::size_t n = 0; n < rows; ++n) across[begin + c][n] = across[begin + c - degree][n] * y[n];
        for (std::size_t n = 0; n < rows; ++n) across[begin + degree][n] = across[begin - 1][n] * r[2];
    }
    std::array<double, count> x;
    for (std::size_t l = 0; l < count; ++l) x[l] = r[0] - static_cast<double>(l) * step;
    std::array<std::array<double, count>, rows> square, inverse, result{};
    for (std::size_t n = 0; n < rows; ++n)
        for (std::size_t l = 0; l < count; ++l) {
            inverse[n][l] = 1 / std::sqrt(x[l] * x[l] + (y[n] * y[n] + r[2] * r[2]));
            square[n][l] = inverse[n][l] * inverse[n][l];
        }
    const double* end = coefficients_.data() + coefficients_.size();
#pragma GCC unroll 8
    for (std::size_t degree = film_degree; degree > 0; --degree) {
        std::array<std::array<double, count>, rows> polynomial{};
#pragma GCC unroll 8
        for (std::size_t left = 0; left <= degree; ++left) {  // the power of x descends
            end -= left + 1;
            std::array<double, rows> factor{};
#pragma GCC unroll 8
            for (std::size_t c = 0; c <= left; ++c)
                for (std::size_t n = 0; n < rows; ++n) factor[n] += end[c] * across[left * (left + 1) / 2 + c][n];
            for (std::size_t n = 0; n < rows; ++n)
                for (std::size_t l = 0; l < count; ++l) polynomial[n][l] = polynomial[n][l] * x[l] + factor[n];
        }
        for (std::size_t n = 0; n < rows; ++n)
            for (std::size_t l = 0; l < count; ++l) result[n][l] = (result[n][l] + polynomial[n][l]) * square[n][l];
    }
    for (std::size_t n = 0; n < rows; ++n)
        for (std::size_t l = 0; l < count; ++l) result[n][l] *= inverse[n][l];
    return result;
}

}  // namespace clsdf

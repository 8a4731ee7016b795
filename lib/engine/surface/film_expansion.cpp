#include "surface/film_expansion.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace clsdf {

namespace {

struct Powers {
    std::size_t x, y, z;

    std::size_t degree() const { return x + y + z; }
};

std::size_t number_of(const Powers& p) {
    const std::size_t degree = p.degree(), before = degree * (degree + 1) * (degree + 2) / 6;
    return before + p.x * (degree + 1) - p.x * (p.x - 1) / 2 + p.z;
}

/// The monomials, and what follows from them alone.
class Tables {
public:
    struct Product {
        std::uint8_t result, first, second;
    };

    static const Tables& get() {
        static const Tables tables;
        return tables;
    }

    const std::array<Powers, film_monomials>& powers() const { return powers_; }
    /// y^a / a!.
    std::array<double, film_monomials> at(const Vec3& y) const {
        std::array<double, film_monomials> values;
        values[0] = 1;
        for (std::size_t i = 1; i < film_monomials; ++i) values[i] = values[lower_[i]] * y[axis_[i]] * inverse_[i];
        return values;
    }
    /// All a = b + c, b not 0.
    const std::vector<Product>& sums() const { return sums_; }
    /// The polynomials h of the derivatives d^a 1/|r| = h(r) / |r|^(2k + 1), k the degree of a.
    const std::array<double, film_monomials>& derivative(std::size_t i) const { return derivatives_[i]; }

    static Powers raised(Powers p, std::size_t axis, std::size_t by = 1) {
        (axis == 0 ? p.x : axis == 1 ? p.y : p.z) += by;
        return p;
    }
    static std::size_t power(const Powers& p, std::size_t axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }
    static Powers lowered(Powers p, std::size_t axis) {
        (axis == 0 ? p.x : axis == 1 ? p.y : p.z) -= 1;
        return p;
    }

private:
    Tables() {
        std::size_t count = 0;
        for (std::size_t degree = 0; degree <= film_degree; ++degree)
            for (std::size_t x = 0; x <= degree; ++x)
                for (std::size_t z = 0; z <= degree - x; ++z) powers_[count++] = {x, degree - x - z, z};
        for (std::size_t i = 1; i < film_monomials; ++i) {
            const Powers& p = powers_[i];
            axis_[i] = p.x > 0 ? 0 : p.y > 0 ? 1 : 2;
            lower_[i] = number_of(lowered(p, axis_[i]));
            inverse_[i] = 1 / static_cast<double>(power(p, axis_[i]));
            for (std::size_t k = 1; k < film_monomials; ++k) {
                const Powers& q = powers_[k];
                if (q.x <= p.x && q.y <= p.y && q.z <= p.z)
                    sums_.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(k),
                                     static_cast<std::uint8_t>(number_of({p.x - q.x, p.y - q.y, p.z - q.z}))});
            }
        }
        derivatives_[0] = {1};
        for (std::size_t i = 1; i < film_monomials; ++i) derive(derivatives_[lower_[i]], powers_[i].degree() - 1, i);
    }

    /// h of one derivative more: |r|^2 dh - (2k + 1) x h.
    void derive(const std::array<double, film_monomials>& h, std::size_t degree, std::size_t i) {
        const std::size_t axis = axis_[i];
        for (std::size_t k = 0; k < film_monomials; ++k) {
            if (h[k] == 0) continue;
            const Powers& p = powers_[k];
            derivatives_[i][number_of(raised(p, axis))] -= static_cast<double>(2 * degree + 1) * h[k];
            if (power(p, axis) == 0) continue;
            for (std::size_t other = 0; other < 3; ++other)
                derivatives_[i][number_of(raised(lowered(p, axis), other, 2))] +=
                    static_cast<double>(power(p, axis)) * h[k];
        }
    }

    std::array<Powers, film_monomials> powers_;
    std::array<std::size_t, film_monomials> axis_{}, lower_{};  // a monomial is the lower one times that axis
    std::array<double, film_monomials> inverse_{};
    std::vector<Product> sums_;
    std::array<std::array<double, film_monomials>, film_monomials> derivatives_{};
};

/// Points of a triangle and their weights: exact for polynomials of degree 4 (Dunavant).
struct TriangleRule {
    struct Orbit {
        double share, weight;  ///< of two corners, and of the point
    };
    std::array<Orbit, 2> orbits;

    TriangleRule() {
        const double root = std::sqrt(38 - 44 * std::sqrt(0.4)), of_ten = std::sqrt(10.0),
                     weight = std::sqrt(213125 - 53320 * of_ten);
        orbits = {
            {{(8 - of_ten + root) / 18, (620 + weight) / 3720}, {(8 - of_ten - root) / 18, (620 - weight) / 3720}}};
    }
};
static_assert(film_degree <= 5, "the gradients of the monomials are integrated exactly");

}  // namespace

void FilmMoments::add_triangle(const Vec3& normal, const std::array<Vec3, 3>& corners) {
    static const TriangleRule rule;
    const Tables& tables = Tables::get();
    for (const TriangleRule::Orbit& orbit : rule.orbits)
        for (std::size_t k = 0; k < 3; ++k) {
            Vec3 y{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                y[axis] = orbit.share * (corners[0][axis] + corners[1][axis] + corners[2][axis]) +
                          (1 - 3 * orbit.share) * corners[k][axis];
            const std::array<double, film_monomials> values = tables.at(y);
            for (std::size_t i = 1; i < film_monomials; ++i) {
                const Powers& p = tables.powers()[i];
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (Tables::power(p, axis) > 0)
                        moments_[i] += orbit.weight * normal[axis] * values[number_of(Tables::lowered(p, axis))];
            }
        }
}

void FilmMoments::add_shifted(const FilmMoments& other, const Vec3& shift) {
    const Tables& tables = Tables::get();
    const std::array<double, film_monomials> powers = tables.at(shift);
    for (const Tables::Product& sum : tables.sums())
        moments_[sum.result] += other.moments_[sum.first] * powers[sum.second];
}

// 4 pi turns = -int n.grad(1 / |r + y|).
FilmExpansion::FilmExpansion(const FilmMoments& moments) {
    const Tables& tables = Tables::get();
    coefficients_.fill(0);
    for (std::size_t i = 1; i < film_monomials; ++i) {
        const std::array<double, film_monomials>& h = tables.derivative(i);
        const std::size_t degree = tables.powers()[i].degree(), begin = degree * (degree + 1) * (degree + 2) / 6;
        for (std::size_t k = begin; k < begin + (degree + 1) * (degree + 2) / 2; ++k)
            coefficients_[k - 1] -= 0.25 * std::numbers::inv_pi * moments.all()[i] * h[k];
    }
}

}  // namespace clsdf

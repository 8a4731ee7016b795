#pragma once

#include <boost/multiprecision/gmp.hpp>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace clsdf::papers {

/// A sum of rational multiples of square roots of whole numbers, none of which is a rational multiple of another. Such
/// roots are linearly independent over the rationals, so the sum is zero only if it has no terms. In a general
/// expression with k roots this takes 2^k times as many digits to decide. It is common on meshes whose vertices lie on
/// a lattice.
class RootSum {
public:
    using Integer = boost::multiprecision::number<boost::multiprecision::gmp_int, boost::multiprecision::et_off>;
    using Rational = boost::multiprecision::number<boost::multiprecision::gmp_rational, boost::multiprecision::et_off>;

    RootSum() = default;
    explicit RootSum(double value) { add(Integer(1), Rational(value)); }

    /// `square` is a rational value that is not negative.
    static RootSum square_root(const RootSum& square) {
        RootSum result;
        if (square.terms_.empty()) return result;
        const Rational& value = square.terms_.front().factor;
        const Integer denominator = boost::multiprecision::denominator(value);
        // Without the powers of four, which are most of what coordinates in double have.
        Integer radicand = boost::multiprecision::numerator(value) * denominator;
        const std::size_t fours = boost::multiprecision::lsb(radicand) / 2;
        radicand >>= 2 * fours;
        result.add(radicand, Rational(Integer(1) << fours) / Rational(denominator));
        return result;
    }

    /// 1, 0 or -1. Times a whole number and a power of two, every term is a root of a whole number, which is known up
    /// to less than one; the power grows until the sum is farther from zero than that.
    int sign() const {
        const auto negative = static_cast<std::size_t>(
            std::count_if(terms_.begin(), terms_.end(), [](const Term& term) { return term.factor < 0; }));
        const std::size_t positive = terms_.size() - negative;
        if (negative == 0) return positive == 0 ? 0 : 1;
        if (positive == 0) return -1;
        const std::vector<Integer> squares = whole_squares();
        for (std::size_t bits = 0;; bits = bits == 0 ? 64 : 2 * bits) {
            Integer sum(0);
            for (std::size_t i = 0; i < terms_.size(); ++i) {
                const Integer root = boost::multiprecision::sqrt(Integer(squares[i] << (2 * bits)));
                sum += terms_[i].factor < 0 ? Integer(-root) : root;
            }
            // The true sum lies between sum - negative and sum + positive, both excluded.
            if (sum >= negative) return 1;
            if (-sum >= positive) return -1;
        }
    }

    friend RootSum operator+(RootSum a, const RootSum& b) {
        for (const Term& term : b.terms_) a.add(term.radicand, term.factor);
        return a;
    }
    friend RootSum operator-(RootSum a, const RootSum& b) {
        for (const Term& term : b.terms_) a.add(term.radicand, -term.factor);
        return a;
    }
    friend RootSum operator*(const RootSum& a, const RootSum& b) {
        RootSum product;
        for (const Term& left : a.terms_)
            for (const Term& right : b.terms_) product.add(left.radicand * right.radicand, left.factor * right.factor);
        return product;
    }
    /// By a single square root.
    friend RootSum operator/(const RootSum& a, const RootSum& root) {
        const Term& term = root.terms_.front();
        RootSum reciprocal;
        reciprocal.add(term.radicand, 1 / (term.factor * Rational(term.radicand)));
        return a * reciprocal;
    }

private:
    struct Term {
        Integer radicand;
        Rational factor;  // not zero
    };

    /// The square root, if that is a whole number.
    static std::optional<Integer> whole_root(const Integer& square) {
        if (mpz_perfect_square_p(square.backend().data()) == 0) return std::nullopt;
        return boost::multiprecision::sqrt(square);
    }

    /// The squares of the terms, all terms multiplied by one whole number.
    std::vector<Integer> whole_squares() const {
        Integer common(1);
        for (const Term& term : terms_)
            common = boost::multiprecision::lcm(common, boost::multiprecision::denominator(term.factor));
        std::vector<Integer> result;
        for (const Term& term : terms_) {
            const Integer factor = boost::multiprecision::numerator(Rational(term.factor * Rational(common)));
            result.push_back(factor * factor * term.radicand);
        }
        return result;
    }

    void add(const Integer& radicand, const Rational& factor) {
        if (factor == 0) return;
        for (auto term = terms_.begin(); term != terms_.end(); ++term) {
            // sqrt(r) = sqrt(r s) / s sqrt(s).
            const std::optional<Integer> root = whole_root(radicand * term->radicand);
            if (!root) continue;
            term->factor += factor * Rational(*root) / Rational(term->radicand);
            if (term->factor == 0) terms_.erase(term);
            return;
        }
        if (const std::optional<Integer> root = whole_root(radicand))
            terms_.push_back({Integer(1), factor * Rational(*root)});
        else
            terms_.push_back({radicand, factor});
    }

    std::vector<Term> terms_;
};

}  // namespace clsdf::papers

#pragma once

#include <CGAL/CORE_BigInt.h>
#include <CGAL/CORE_BigRat.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel_with_sqrt.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace clsdf::peikert_sigg {

/// A sum of rational multiples of square roots of whole numbers, none of which is a rational multiple of another. Such
/// roots are linearly independent over the rationals, so that the sum is zero exactly where it has no terms: what takes
/// a general expression with k roots 2^k times as many digits, and is common on meshes whose vertices lie on a lattice.
class RootSum {
public:
    using Integer = CORE::BigInt;
    using Rational = CORE::BigRat;
    using Real = CGAL::Exact_predicates_exact_constructions_kernel_with_sqrt::FT;

    RootSum() = default;
    explicit RootSum(double value) { add(Integer(1), Rational(value)); }

    /// Of a rational value that is not negative.
    static RootSum square_root(const RootSum& square) {
        RootSum result;
        if (square.terms_.empty()) return result;
        const Rational& value = square.terms_.front().factor;
        const Integer denominator = CORE::denominator(value);
        // Without the powers of four, which are most of what coordinates in double have.
        Integer radicand = CORE::numerator(value) * denominator;
        const unsigned long fours = mpz_scan1(radicand.get_mp(), 0) / 2;
        radicand >>= 2 * fours;
        result.add(radicand, Rational(Integer(1) << fours) / Rational(denominator));
        return result;
    }

    int sign() const {
        if (terms_.empty()) return 0;
        if (terms_.size() == 1) return sign_of(terms_.front().factor);
        Real sum(0);
        for (const Term& term : terms_) sum += Real(term.factor) * CGAL::sqrt(Real(term.radicand));
        return static_cast<int>(CGAL::sign(sum));
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
        reciprocal.add(term.radicand, Rational(Integer(1)) / (term.factor * Rational(term.radicand)));
        return a * reciprocal;
    }

private:
    struct Term {
        Integer radicand;
        Rational factor;  // not zero
    };

    static int sign_of(const Rational& value) { return mpq_sgn(value.get_mp()); }

    /// The square root, where that is a whole number.
    static std::optional<Integer> whole_root(const Integer& square) {
        if (mpz_perfect_square_p(square.get_mp()) == 0) return std::nullopt;
        Integer root;
        mpz_sqrt(root.get_mp(), square.get_mp());
        return root;
    }

    void add(const Integer& radicand, const Rational& factor) {
        if (sign_of(factor) == 0) return;
        for (auto term = terms_.begin(); term != terms_.end(); ++term) {
            // sqrt(r) = sqrt(r s) / s sqrt(s).
            const std::optional<Integer> root = whole_root(radicand * term->radicand);
            if (!root) continue;
            term->factor += factor * Rational(*root) / Rational(term->radicand);
            if (sign_of(term->factor) == 0) terms_.erase(term);
            return;
        }
        if (const std::optional<Integer> root = whole_root(radicand))
            terms_.push_back({Integer(1), factor * Rational(*root)});
        else
            terms_.push_back({radicand, factor});
    }

    std::vector<Term> terms_;
};

}  // namespace clsdf::peikert_sigg

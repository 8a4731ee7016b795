#include "polyhedra/fan_rejections.hpp"

#include <algorithm>
#include <array>

namespace clsdf::polyhedra {

namespace {

constexpr std::size_t few_faces = 12;
constexpr std::size_t all_triples = 9;  // of so many faces are tried

/// The sign of the t for which t middle is a combination of three vectors by positive factors; 0 where t may be 0, or
/// where the vectors do not surely run counter-clockwise around `middle`, as the faces of a fan do around its mean
/// normal. (Where they run clockwise there is such a combination too, which is not looked for.)
int sign_of_combination(const Vector& a, const Vector& b, const Vector& c, const Vector& middle) {
    // middle . (b x c) a + middle . (c x a) b + middle . (a x b) c = det(a, b, c) middle
    const Vector cross = b.cross(c);
    const double of_a = middle.dot(cross);
    const double of_b = middle.dot(c.cross(a));
    const double of_c = middle.dot(a.cross(b));
    if (!(std::min({of_a, of_b, of_c}) > certain_product)) return 0;
    const double determinant = a.dot(cross);
    return determinant > certain_product ? 1 : determinant < -certain_product ? -1 : 0;
}

/// Conditions v . u >= 0, a face each.
class Conditions {
public:
    void add(const Vector& v) { vectors_[count_++] = v; }

    /// Whether three of the conditions combine to sign * middle . u >= 0, strictly but for u = 0. Those a third of the
    /// fan apart mostly do.
    bool combine(const Vector& middle, int sign) const {
        const auto is_found = [&](std::size_t i, std::size_t j, std::size_t k) {
            return sign_of_combination(vectors_[i], vectors_[j], vectors_[k], middle) == sign;
        };
        const std::size_t third = (count_ + 1) / 3;
        for (std::size_t i = 0; i < third; ++i)
            if (is_found(i, i + third, std::min(i + 2 * third, count_ - 1))) return true;
        if (count_ > all_triples) return false;
        for (std::size_t i = 0; i < count_; ++i)
            for (std::size_t j = i + 1; j < count_; ++j)
                for (std::size_t k = j + 1; k < count_; ++k)
                    if (is_found(i, j, k)) return true;
        return false;
    }

private:
    std::array<Vector, few_faces> vectors_;
    std::size_t count_ = 0;
};

}  // namespace

// A plane of slope a above a face with outward direction R and normal N rejects the unit vector u by the margin where
// (R - a N) . u >= margin (1 + a), the slack's unit being 1 + a; one of slope b below it where (R + b N) . u >= margin
// (1 + b). The plane of an edge is the higher one of the two, so that u satisfies both. As |middle . u| <= 1, it also
// satisfies (R - a N - margin (1 + a) middle) . u >= 0 and (R + b N + margin (1 + b) middle) . u >= 0.
//
// If three of the former, v_i, combine to -middle, then middle . u <= 0, and if three of the latter combine to middle,
// then middle . u >= 0. So middle . u = 0, all v_i . u = 0, and u = 0 because the v_i are independent: there is no u.
bool cannot_all_reject(std::span<const LateralPlane> planes, double margin) {
    if (planes.size() > few_faces) return false;
    Vector middle = Vector::Zero();
    for (const LateralPlane& plane : planes) {
        if (plane.steepest() > static_cast<float>(steepest_slope)) return false;
        middle += plane.normal;
    }
    middle /= static_cast<double>(planes.size());

    const double certain_margin = certain_part * margin;
    Conditions above;
    Conditions below;
    for (const LateralPlane& plane : planes) {
        const auto a = static_cast<double>(plane.above);
        const auto b = static_cast<double>(plane.below);
        above.add(-plane.inward - a * plane.normal - certain_margin * (1 + a) * middle);
        below.add(-plane.inward + b * plane.normal + certain_margin * (1 + b) * middle);
    }
    return above.combine(middle, -1) && below.combine(middle, 1);
}

}  // namespace clsdf::polyhedra

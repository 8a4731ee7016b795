#include "polyhedra/cone_search.hpp"

#include <cmath>

namespace clsdf::polyhedra {

namespace {

using Vector2 = Eigen::Vector2d;

/// The directions of a circle that satisfy conditions c . u >= 0: an arc of at most half a turn, from one end
/// counter-clockwise to the other, once there is a condition. An end is kept as long as the condition that it comes
/// from, so that most cuts need neither a root nor a division.
class Arc {
public:
    enum class Answer { not_empty, empty, undecided };

    Answer cut(const Vector2& condition) {
        const double squared = condition.squaredNorm();
        if (!(squared > negligible * negligible))
            return Answer::not_empty;  // the circle is nearly that condition's own
        if (is_whole_) {
            is_whole_ = false;
            first_ = {first_direction(condition), squared};
            last_ = {-first_.direction, squared};
            return Answer::not_empty;
        }
        const double at_first = condition.dot(first_.direction);
        const double at_last = condition.dot(last_.direction);
        if (at_first >= 0 && at_last >= 0) return leaves_middle(condition);
        if (at_first < 0 && at_last < 0)
            return is_certain(at_first, squared, first_) && is_certain(at_last, squared, last_) ? Answer::empty
                                                                                                : Answer::undecided;
        if (at_first < 0) {
            first_ = {first_direction(condition), squared};
        } else {
            last_ = {first_direction(-condition), squared};
        }
        return Answer::not_empty;
    }

    Vector2 middle() const {
        if (is_whole_) return {1, 0};
        // The ends of half a turn cancel; its middle is a quarter turn after the first one.
        if (is_half_turn()) return {-first_.direction.y(), first_.direction.x()};
        return first_.direction / std::sqrt(first_.squared) + last_.direction / std::sqrt(last_.squared);
    }

private:
    /// Between the rounding of a product, 1e-15, and what decides anything about a mesh, 1e-6 (the margin of a gap).
    static constexpr double tolerance = 1e-12;
    static constexpr double negligible = 1e-14;

    struct End {
        Vector2 direction;
        double squared;  // its length's; rounding may have moved it by the tolerance
    };

    /// Where the half turn that satisfies the condition begins.
    static Vector2 first_direction(const Vector2& condition) { return {condition.y(), -condition.x()}; }

    /// Whether a product of a condition with an end is not 0 by rounding: the tolerance times the sum of their lengths.
    static bool is_certain(double product, double squared, const End& end) {
        return product * product > 2 * tolerance * tolerance * (squared + end.squared);
    }

    bool is_half_turn() const {
        const double product = first_.direction.dot(last_.direction);
        return product < 0 && product * product > (1 - 2e-12) * first_.squared * last_.squared;
    }

    /// Both ends are inside, so everything is, unless the arc is half a turn that turns its back on the condition: then
    /// it hangs on rounding whether its ends are left.
    Answer leaves_middle(const Vector2& condition) const {
        return is_half_turn() && condition.dot(middle()) < 0 ? Answer::undecided : Answer::not_empty;
    }

    bool is_whole_ = true;
    End first_{Vector2::Zero(), 0};
    End last_{Vector2::Zero(), 0};
};

}  // namespace

bool ConeSearch::move_to_circle_of_last() {
    // x and y are perpendicular to the last condition, about equally long, and not short; no more is needed.
    const Vector& pole = conditions_.back();
    Vector x = direction_ - direction_.dot(pole) / pole.squaredNorm() * pole;
    if (x.squaredNorm() < 0.01) x = any_perpendicular(pole.normalized());
    const Vector y = pole.cross(x);
    Arc arc;
    for (std::size_t i = 0; i + 1 < conditions_.size(); ++i) {
        const Arc::Answer answer = arc.cut({conditions_[i].dot(x), conditions_[i].dot(y)});
        if (answer == Arc::Answer::empty) return false;
        // The arc then stays as it is, too large rather than too small: what follows may still prove it empty.
        if (answer == Arc::Answer::undecided) undecided_ = true;
    }
    if (undecided_) return true;
    const Vector2 middle = arc.middle();
    direction_ = (middle.x() * x + middle.y() * y).normalized();
    return true;
}

}  // namespace clsdf::polyhedra

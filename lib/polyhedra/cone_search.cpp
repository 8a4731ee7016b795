#include "polyhedra/cone_search.hpp"

#include <cmath>

namespace clsdf::polyhedra {

namespace {

using Vector2 = Eigen::Vector2d;

/// The directions of a circle that satisfy conditions c . u >= 0: an arc of at most half a turn, from one end
/// counter-clockwise to the other, once there is a condition.
class Arc {
public:
    enum class Answer { not_empty, empty, undecided };

    Answer cut(const Vector2& condition) {
        const double squared = condition.squaredNorm();
        if (!(squared > negligible * negligible))
            return Answer::not_empty;  // the circle is nearly that condition's own
        if (is_whole_) {
            is_whole_ = false;
            first_ = first_end(condition);
            last_ = {-first_.direction, first_.error};
            return Answer::not_empty;
        }
        const double at_first = condition.dot(first_.direction);
        const double at_last = condition.dot(last_.direction);
        if (at_first >= 0 && at_last >= 0) return leaves_middle(condition);
        if (at_first < 0 && at_last < 0) {
            const double length = std::sqrt(squared);
            const bool is_certain =
                at_first < -tolerance - length * first_.error && at_last < -tolerance - length * last_.error;
            return is_certain ? Answer::empty : Answer::undecided;
        }
        if (at_first < 0) {
            first_ = first_end(condition);
        } else {
            last_ = first_end(-condition);
        }
        return Answer::not_empty;
    }

    Vector2 middle() const {
        if (is_whole_) return {1, 0};
        // The ends of half a turn cancel; its middle is a quarter turn after the first one.
        if (is_half_turn()) return {-first_.direction.y(), first_.direction.x()};
        return first_.direction + last_.direction;
    }

private:
    /// Between the rounding of a product, 1e-15, and what decides anything about a mesh, 1e-6 (the margin of a gap).
    static constexpr double tolerance = 1e-12;
    static constexpr double negligible = 1e-14;

    struct End {
        Vector2 direction;  // of unit length
        double error;       // angle by which rounding may have moved it
    };

    /// Where the half turn that satisfies the condition begins.
    static End first_end(const Vector2& condition) {
        const double scale = 1 / condition.norm();
        return {{scale * condition.y(), -scale * condition.x()}, scale * tolerance};
    }

    bool is_half_turn() const { return first_.direction.dot(last_.direction) < -1 + 1e-12; }

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
        if (answer == Arc::Answer::undecided) return undecided_ = true;
    }
    const Vector2 middle = arc.middle();
    direction_ = (middle.x() * x + middle.y() * y).normalized();
    return true;
}

}  // namespace clsdf::polyhedra

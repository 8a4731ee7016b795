#include "polyhedra/cone_search.hpp"

#include <cmath>

namespace clsdf::polyhedra {

namespace {

using Vector2 = Eigen::Vector2d;

/// The directions of a circle that satisfy conditions c . u >= 0: an arc of at most half a turn, from `first`
/// counter-clockwise to `last`, once there is a condition.
class Arc {
public:
    /// False where the arc becomes empty.
    bool cut(const Vector2& condition) {
        const double squared = condition.squaredNorm();
        if (!(squared > parallel * parallel)) return true;  // the circle is that condition's own, up to rounding
        const Vector2 first(condition.y(), -condition.x());
        if (is_whole_) {
            is_whole_ = false;
            first_ = first;
            last_ = -first;
            return true;
        }
        const double at_first = condition.dot(first_);
        const double at_last = condition.dot(last_);
        if (at_first >= 0 && at_last >= 0) return keep_half(condition);
        if (at_first < 0 && at_last < 0) return collapse(at_first, at_last, squared);
        if (at_first < 0) first_ = first;
        if (at_last < 0) last_ = -first;
        return true;
    }

    /// A direction in the middle, not of unit length.
    Vector2 middle() const {
        if (is_whole_) return {1, 0};
        const Vector2 sum = first_ + std::sqrt(first_.squaredNorm() / last_.squaredNorm()) * last_;
        // The ends of half a turn cancel; its middle is a quarter turn after the first one.
        return sum.squaredNorm() > 1e-16 * first_.squaredNorm() ? sum : Vector2(-first_.y(), first_.x());
    }

private:
    static constexpr double parallel = 1e-13;
    static constexpr double tolerance = 1e-12;
    static constexpr double half_turn = 1e-12;

    /// Both ends are inside, so everything is, unless the arc is half a turn that turns its back on the condition: then
    /// only its ends are left, and either will do.
    bool keep_half(const Vector2& condition) {
        const double dot = first_.dot(last_);
        const bool is_half = dot < 0 && (1 - half_turn) * first_.squaredNorm() * last_.squaredNorm() < dot * dot;
        if (is_half && condition.dot(middle()) < 0) last_ = first_;
        return true;
    }

    /// Both ends are outside: if not by more than rounding, the better one stays.
    bool collapse(double at_first, double at_last, double squared) {
        const double first = at_first / std::sqrt(squared * first_.squaredNorm());
        const double last = at_last / std::sqrt(squared * last_.squaredNorm());
        if (first < -tolerance && last < -tolerance) return false;
        if (first > last) {
            last_ = first_;
        } else {
            first_ = last_;
        }
        return true;
    }

    bool is_whole_ = true;
    Vector2 first_ = Vector2::Zero();
    Vector2 last_ = Vector2::Zero();
};

}  // namespace

bool ConeSearch::move_to_circle_of_last() {
    // x and y are perpendicular to the last condition, and about equally long; no more is needed.
    const Vector& pole = conditions_.back();
    Vector x = direction_ - direction_.dot(pole) / pole.squaredNorm() * pole;
    if (x.squaredNorm() < 1e-4) x = any_perpendicular(pole.normalized());
    const Vector y = pole.cross(x);
    Arc arc;
    for (std::size_t i = 0; i + 1 < conditions_.size(); ++i)
        if (!arc.cut({conditions_[i].dot(x), conditions_[i].dot(y)})) return false;
    const Vector2 middle = arc.middle();
    direction_ = (middle.x() * x + middle.y() * y).normalized();
    return true;
}

}  // namespace clsdf::polyhedra

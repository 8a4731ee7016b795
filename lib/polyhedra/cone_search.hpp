#pragma once

#include "polyhedra/vector.hpp"

#include <cstddef>
#include <vector>

namespace clsdf::polyhedra {

/// Looks for a direction u with g_i . u >= 0 for every condition g_i added so far: a linear programme on the sphere,
/// solved incrementally. It has no chart and so no direction at infinity.
///
/// A condition that holds at the present direction costs one product. If it fails, a solution, if there is any, lies on
/// the great circle of that condition: the directions of the earlier conditions are convex and reach from the present
/// direction to the other side. In random order this happens log n times.
///
/// The answer "none" is certain. If the answer depends on rounding, the search gives up and says that there may be a
/// direction.
class ConeSearch {
public:
    struct State {
        std::size_t conditions = 0;
        Vector direction;
        bool undecided = false;
    };

    void start(const Vector& first_guess) { return_to({0, first_guess, false}); }

    /// Adds a condition of about unit length. Returns false if no direction satisfies all of them; then no more may be
    /// added.
    bool add(const Vector& condition) {
        conditions_.push_back(condition);
        return undecided_ || condition.dot(direction_) >= -rounding || move_to_circle_of_last();
    }

    /// A unit vector that satisfies all conditions, up to rounding, unless the search is undecided.
    const Vector& direction() const { return direction_; }
    bool is_undecided() const { return undecided_; }

    /// To try several continuations.
    State state() const { return {conditions_.size(), direction_, undecided_}; }
    void return_to(const State& state) {
        conditions_.resize(state.conditions);
        direction_ = state.direction;
        undecided_ = state.undecided;
    }

private:
    static constexpr double rounding = 1e-14;  // of a condition's product with a direction

    bool move_to_circle_of_last();

    std::vector<Vector> conditions_;
    Vector direction_ = Vector::UnitX();
    bool undecided_ = false;
};

}  // namespace clsdf::polyhedra

#pragma once

#include "polyhedra/vector.hpp"

#include <cstddef>
#include <vector>

namespace clsdf::polyhedra {

/// Looks for a direction u with g_i . u >= 0 for every condition g_i added so far: a linear programme on the sphere,
/// solved incrementally. It has no chart and so no direction at infinity.
///
/// Conditions that hold at the direction found so far cost one product. Where one fails, a direction, if there still is
/// one, can be found on the great circle of that condition, because the directions of the earlier conditions are convex
/// and reach from the old direction to the other side. In random order that happens log n times.
class ConeSearch {
public:
    struct State {
        std::size_t conditions = 0;
        Vector direction;
    };

    void start(const Vector& first_guess) {
        conditions_.clear();
        direction_ = first_guess;
    }

    /// Adds a condition of about unit length. False where no direction satisfies all of them; nothing may be added
    /// then.
    bool add(const Vector& condition) {
        conditions_.push_back(condition);
        return condition.dot(direction_) >= 0 || move_to_circle_of_last();
    }

    /// A unit vector that satisfies all conditions, up to rounding.
    const Vector& direction() const { return direction_; }

    /// To try several continuations.
    State state() const { return {conditions_.size(), direction_}; }
    void return_to(const State& state) {
        conditions_.resize(state.conditions);
        direction_ = state.direction;
    }

private:
    bool move_to_circle_of_last();

    std::vector<Vector> conditions_;
    Vector direction_ = Vector::UnitX();
};

}  // namespace clsdf::polyhedra

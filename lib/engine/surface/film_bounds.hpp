#pragma once

#include <clsdf/mesh.hpp>

#include "core/vectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

/// How the winding number changes in a ball around a point, because of the open edges: bounds of docs/method.md, 'Sign
/// of open meshes'. Lengths are in any unit.
namespace clsdf {

/// In turns: above the rounding of all sums, and of their bounds.
constexpr double film_slack = 1e-6;
/// The most that pieces of a film far away may be off by together, in turns: first a rough sum, then better ones; at
/// last all open edges are summed.
constexpr std::array<double, 3> film_tolerances{1.0 / 8, 1.0 / 128, 1.0 / 4096};

struct WindingChange {
    double most = 0;
    Vec3 gradient{};    ///< at the point
    double beside = 0;  ///< the most that the gradient does not tell

    void add(const WindingChange& other) {
        most += other.most;
        beside += other.beside;
        for (std::size_t axis = 0; axis < 3; ++axis) gradient[axis] += other.gradient[axis];
    }
    double bound(double radius) const { return std::min(most, length(gradient) * radius + beside); }
};

/// The change in a ball of such radius by a film of such area, whose convex hull is so far away from the ball.
inline double film_change(double area, double away, double radius) {
    return radius * (area * (0.5 * std::numbers::inv_pi)) / (away * away * away);
}

/// The change by a loop.
class LoopChange {
public:
    /// distance: of the point from the middle of a ball of `loop_radius` around the loop. area: of any film in the loop
    /// that lies in that ball. radius: of the ball in which the winding number changes.
    LoopChange(double distance, double loop_radius, double area, double radius) : radius_(radius) {
        const double away = distance - loop_radius - radius;
        if (!(away > 0)) return;
        most_ = film_change(area, away, radius);
        beside_ = 1.5 * radius / away * most_;
        is_far_ = most_ < 1e-3;
    }

    /// An edge; its ends minus the point.
    void add_edge(const Vec3& a, const Vec3& b) {
        const double length_a = length(a), length_b = length(b), both = length_a * length_b;
        const double across = both * (both + dot(a, b));
        if (across > 0) {  // the law of Biot and Savart
            const double factor = per_sphere * (length_a + length_b) / across;
            change_.gradient[0] += factor * (a[1] * b[2] - a[2] * b[1]);
            change_.gradient[1] += factor * (a[2] * b[0] - a[0] * b[2]);
            change_.gradient[2] += factor * (a[0] * b[1] - a[1] * b[0]);
        }
        if (is_far_) return;  // the bounds by the loop suffice
        const Vec3 along{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const double squared = dot(along, along), edge = std::sqrt(squared);
        const double share = squared > 0 ? std::clamp(-dot(a, along) / squared, 0.0, 1.0) : 0;
        const double away =
            length({a[0] + share * along[0], a[1] + share * along[1], a[2] + share * along[2]}) - radius_;
        if (away > 0) {
            change_.most += radius_ * per_sphere * std::min(2 / away, edge / (away * away));
            change_.beside += 0.5 * radius_ * radius_ * per_sphere * std::min(2 * edge / away, 4.0) / (away * away);
        } else {
            change_.most = change_.beside = infinite;
        }
    }

    WindingChange change() const {
        WindingChange result = change_;
        result.most = is_far_ ? most_ : std::min(result.most, most_);
        result.beside = is_far_ ? beside_ : std::min(result.beside, beside_);
        return result;
    }

private:
    static constexpr double per_sphere = 0.25 * std::numbers::inv_pi;
    static constexpr double infinite = std::numeric_limits<double>::infinity();

    double radius_;
    double most_ = infinite, beside_ = infinite;
    bool is_far_ = false;
    WindingChange change_;
};

/// The distance of the winding number, known up to an integer, from the nearest half integer.
inline double distance_to_half(double turns) {
    return std::abs(turns - std::floor(turns) - 0.5);
}

}  // namespace clsdf

#pragma once

#include "frusta/frames.hpp"
#include "frusta/slopes.hpp"
#include "frusta/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::engine {

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

enum VertexMark : std::uint8_t {
    vertex_saddle = 1,  ///< convex and concave edges meet there
    vertex_gap = 2,     ///< directions may be left out by the polyhedra of all its faces: it needs a point site
};

/// A direction that is rejected by less than this lies within a quarter of the slack of the polyhedron (docs/method.md,
/// 'Gaps at saddle vertices').
///
/// A quarter of the slack 1e-3 + 2e-5 d is d times this or more, for every distance d in units.
inline constexpr double rejection_margin = 5e-6;

/// VertexMark of each of `vertices`. A vertex without vertex_gap has its whole normal cone in its faces' polyhedra,
/// widened by a quarter of the slack. `measured`: at least all faces around them; their slopes are leaned.
std::vector<std::uint8_t> find_gaps(const MeshFaces& faces, std::span<const FaceEdges> edges, const OneRings& rings,
                                    const MeasuredFaces& measured, std::span<const std::uint32_t> vertices);

}  // namespace clsdf::engine

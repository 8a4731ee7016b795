#pragma once

#include "piece.h"
#include "polyhedra/convex_polyhedron.hpp"

#include <span>
#include <vector>

namespace clsdf::slices {

/// The cone of a vertex: {u : u . n <= 0 for the directions n to all neighbours} (docs/method.md, 'What an exact
/// polyhedron must contain'), and what bounds its part of the unit ball.
class MauchCone {
public:
    /// normal . u <= 0, or <= 1 where it is a cap; of unit length.
    struct Bound {
        polyhedra::Vector normal;
        bool is_cap;
    };

    void start() { half_spaces_.clear(); }
    void add(const polyhedra::Vector& neighbour) { half_spaces_.push_back({neighbour, 0}); }

    /// False where the cone is empty, or thinner than 2e-13; its bounds are then those of what may be left of it. Of
    /// very many neighbours a few are kept, which bound the cone and little more.
    bool build();

    /// CLSDF_MOST_PLANES at most, which may leave more than the cone where it has very many neighbours: a vertex is a
    /// bound of the distance wherever the sample lies.
    std::span<const Bound> bounds() const { return bounds_; }

private:
    void add_cap(const polyhedra::Vector& normal) { bounds_.push_back({normal, true}); }
    void add_caps_around(const polyhedra::Vector& axis);

    std::vector<polyhedra::HalfSpace> half_spaces_;
    std::vector<Bound> bounds_;
};

}  // namespace clsdf::slices

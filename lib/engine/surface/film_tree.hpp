#pragma once

#include "solid_angle.h"
#include "surface/film_nodes.hpp"
#include "surface/open_edges.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace clsdf {

/// The film of a mesh's open edges as points see it, by a tree: one point costs much less than the sum over all open
/// edges. Safe to use from several threads.
class FilmTree {
public:
    /// unit: as of angle_of().
    FilmTree(std::shared_ptr<const OpenBoundary> boundary, double unit);

    struct View {
        int rounded;     ///< SolidAngle::rounded
        double to_half;  ///< the winding number is farther from every half integer; may be negative
    };
    /// The open edges as a point sees them. If the moments show no distance greater than `least_to_half`, the sum over
    /// all open edges is taken. So `rounded` is the same by both ways wherever the sum is right.
    View look(const Vec3& point, double least_to_half = 0) const;
    /// The same from moments, as exactly as to tell between which tenths the winding number lies, or nearly so.
    View look_by_tenths(const Vec3& point) const;

    /// How much the winding number changes in a ball around a point, at most. radius: in the unit.
    double change_within(const Vec3& centre, double radius) const;

    const OpenBoundary& boundary() const { return *boundary_; }
    /// Without the boundary.
    std::size_t host_bytes() const { return nodes_.host_bytes() + corners_.size() * sizeof(corners_[0]); }

private:
    struct Sum {
        Turns near = no_turns();  ///< the turns of the pieces near the point
        FilmNodes::Sum far;       ///< those of all others
    };

    Vec3 scaled(const Vec3& position) const;
    /// By the sum over all open edges.
    View look_at_all(const Vec3& point) const;
    Sum sum(const Vec3& point, double tolerance) const;

    std::shared_ptr<const OpenBoundary> boundary_;
    double unit_;
    FilmNodes nodes_;            // in the unit
    std::vector<Vec3> corners_;  // of the boundary, in the order of the nodes: neighbours lie together
};

}  // namespace clsdf

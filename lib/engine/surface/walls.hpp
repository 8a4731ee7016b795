#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/box_index.hpp"
#include "surface/open_edges.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace clsdf {

/// The walls from the rim of a terrain down to its floor, and the floor, for the sign rule `below`. With the terrain
/// they are a closed surface. Rays along x cross walls alone, because the floor is horizontal. Safe to use from several
/// threads.
class Walls {
public:
    /// boundary: with a floor.
    explicit Walls(std::shared_ptr<const OpenBoundary> boundary);

    double floor() const { return *boundary_->floor; }
    /// What the walls add to the crossings of a point's ray towards -x: see crossing_of_wall().
    int crossings(const Vec3& point) const;
    /// Whether a wall may meet the box; exact for boxes that do not reach above the wall's upper edge.
    bool may_meet(const Box& box) const;

    /// Without the boundary.
    std::size_t host_bytes() const { return 2 * boundary_->corners.size() * sizeof(Box); }

private:
    struct Edge {
        const Vec3& from;
        const Vec3& to;
    };
    /// The edge that begins at a corner.
    Edge edge(std::size_t corner) const { return {boundary_->corners[corner], boundary_->corners[next_[corner]]}; }

    std::shared_ptr<const OpenBoundary> boundary_;
    std::vector<std::uint32_t> next_;  // of each corner, the next one of its loop
    BoxIndex index_;                   // of the walls, by the corners at which their edges begin
};

}  // namespace clsdf

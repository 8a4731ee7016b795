#pragma once

#include "polyhedra/lateral_plane.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/prefetch.hpp"
#include "polyhedra/slopes.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace clsdf::polyhedra {

/// The lateral planes of all faces.
class FramePlanes {
public:
    /// From a face's frame.
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): arrays are left unset until all cores fill them
    struct Directions {
        Vector normal;
        std::array<Vector, 3> inwards;
    };

    FramePlanes(std::span<const Directions> directions, std::span<const FaceSlopes> slopes)
        : directions_(directions), slopes_(slopes) {}

    const Vector& normal(std::size_t face) const { return directions_[face].normal; }

    LateralPlane plane(const Corner& edge) const {
        const Directions& face = directions_[edge.face];
        const FaceSlopes& slopes = slopes_[edge.face];
        return {face.normal, face.inwards[edge.vertex], slopes.above[edge.vertex], slopes.below[edge.vertex]};
    }

    /// Prefetches the numbers of a face.
    void fetch_ahead(std::size_t face) const {
        prefetch(&directions_[face]);
        prefetch(&directions_[face].inwards[2]);
        prefetch(&slopes_[face]);
    }

private:
    std::span<const Directions> directions_;
    std::span<const FaceSlopes> slopes_;
};

}  // namespace clsdf::polyhedra

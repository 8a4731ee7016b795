#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/prefetch.hpp"
#include "polyhedra/triangle_frame.hpp"
#include "polyhedra/vector.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// Slopes of the lateral planes of a face's edges, above the face and below it (docs/method.md, 'Leaned frusta').
namespace clsdf::polyhedra {

/// The slopes of one edge's planes, above the face and below it.
struct EdgeSlope {
    float above;
    float below;
};

/// By edge of a face.
struct FaceSlopes {
    std::array<float, 3> above;
    std::array<float, 3> below;
};

/// `x` >= 0 as a float that is not below it, also after the roundings that led to it.
inline float widened(double x) {
    return static_cast<float>(x * (1 + 1e-6));
}

/// If the corner opposite the base is obtuse, its two planes lean outward until each contains the wedge of the other;
/// otherwise they would cut it off. No other corner of a triangle is obtuse.
void lean(const TriangleFrame& frame, FaceSlopes& slopes);

/// The parts of the planes at a face's edge, above the face and below it.
struct LateralPlane {
    Vector normal;  ///< of the face
    Vector inward;  ///< unit vector in the face's plane, perpendicular to the edge
    float above;    ///< slopes
    float below;
};

/// The lateral planes of all faces, or of some.
class FramePlanes {
public:
    /// From a face's frame.
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): arrays are left unset until all cores fill them
    struct Directions {
        Vector normal;
        std::array<Vector, 3> inwards;
    };

    /// `faces`: whose directions they are, ascending; empty for all. `slopes`: of all.
    FramePlanes(std::span<const Directions> directions, std::span<const FaceSlopes> slopes,
                std::span<const std::uint32_t> faces = {})
        : directions_(directions), slopes_(slopes), faces_(faces) {}

    const Vector& normal(std::size_t face) const { return directions_[place(face)].normal; }

    LateralPlane plane(const Corner& edge) const {
        const Directions& face = directions_[place(edge.face)];
        const FaceSlopes& slopes = slopes_[edge.face];
        return {face.normal, face.inwards[edge.vertex], slopes.above[edge.vertex], slopes.below[edge.vertex]};
    }

    /// Prefetches the numbers of a face.
    void fetch_ahead(std::size_t face) const {
        if (!faces_.empty()) return;
        prefetch(&directions_[face]);
        prefetch(&directions_[face].inwards[2]);
        prefetch(&slopes_[face]);
    }

private:
    std::size_t place(std::size_t face) const {
        if (faces_.empty()) return face;
        return static_cast<std::size_t>(std::lower_bound(faces_.begin(), faces_.end(), face) - faces_.begin());
    }

    std::span<const Directions> directions_;
    std::span<const FaceSlopes> slopes_;
    std::span<const std::uint32_t> faces_;
};

}  // namespace clsdf::polyhedra

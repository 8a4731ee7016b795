#pragma once

#include "core/large_memory.hpp"
#include "tree/point_mesh.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>

namespace clsdf::engine {

/// The faces of a PointMesh as exact predicates read them (kernels/common/expansions.h): in units, from the origin of
/// the caller's coordinates.
struct CrossedFaces {
    using Corners = std::array<Vec3, 3>;

    bool are_exact = false;  ///< all coordinates are in the range of exact arithmetic; if not, there are no corners
    UninitializedVector<Corners> corners;       ///< by face
    UninitializedVector<Corners> sign_corners;  ///< those that decide the sign; empty: the same

    // Of the mesh, in units; beyond a ball around its centre nothing is inside, also not by the film.
    Vec3 centre{};
    double diagonal = 0;
    double radius = 0;  ///< of the ball

    const Corners& of_sign(std::size_t face) const { return sign_corners.empty() ? corners[face] : sign_corners[face]; }
    std::size_t host_bytes() const { return (corners.size() + sign_corners.size()) * sizeof(Corners); }
};

CrossedFaces make_crossed_faces(const PointMesh& mesh);

/// The same point in units, from the origin of the caller's coordinates. Exact if is_exact_in_units() says so.
inline Vec3 scaled(const Vec3& p, double per_unit) {
    return {p[0] * per_unit, p[1] * per_unit, p[2] * per_unit};
}
/// Whether scaled() is finite and in the range of exact arithmetic.
bool is_exact_in_units(const Vec3& p, double per_unit);

}  // namespace clsdf::engine

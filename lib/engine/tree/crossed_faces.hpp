#pragma once

#include "tree/point_mesh.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace clsdf::engine {

/// The same point in units, from the origin of the caller's coordinates. Exact if is_exact_in_units() says so.
inline Vec3 scaled(const Vec3& p, double per_unit) {
    return {p[0] * per_unit, p[1] * per_unit, p[2] * per_unit};
}
/// Whether scaled() is finite and in the range of exact arithmetic (kernels/common/expansions.h).
bool is_exact_in_units(const Vec3& p, double per_unit);

/// The faces of a mesh as exact predicates read them: in units, from the origin of the caller's coordinates.
struct CrossedFaces {
    using Corners = std::array<Vec3, 3>;

    const PointMesh& mesh;
    std::span<const std::uint32_t> numbers{};  ///< of a part's triangles, in the whole mesh; empty for the whole
    double per_unit = 1 / mesh.lattice.unit;

    std::size_t count() const { return mesh.face_count(); }
    Corners corners(std::size_t face) const { return in_units(mesh.corners(face)); }
    /// Those that decide the sign.
    Corners sign_corners(std::size_t face) const { return in_units(mesh.sign_corners(face)); }
    /// The caller's number, or no_triangle.
    std::uint32_t triangle(std::size_t face) const {
        const std::uint32_t number = mesh.topology->order[face];
        return numbers.empty() || number == no_triangle ? number : numbers[number];
    }

private:
    Corners in_units(Corners corners) const {
        for (Vec3& corner : corners) corner = scaled(corner, per_unit);
        return corners;
    }
};

/// Whether all coordinates are in the range of exact arithmetic.
bool are_exact(const PointMesh& mesh);
/// Throws Error(unsupported), which names the first coordinate that is not. name: the mesh's.
[[noreturn]] void refuse_inexact(const PointMesh& mesh, const std::string& name);

/// What is kept of the faces for rays.
struct CrossedExtent {
    bool are_exact = false;
    // Of a mesh with a film, in units; beyond a ball around its centre nothing is inside.
    Vec3 centre{};
    double diagonal = 0;
    double radius = 0;  ///< of the ball

    static std::size_t host_bytes() { return sizeof(CrossedExtent); }
};
CrossedExtent crossed_extent(const PointMesh& mesh);

}  // namespace clsdf::engine

#pragma once

#include "polyhedra/triangle_frame.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <span>

namespace clsdf::polyhedra {

/// Faces of a mesh, in an order of their own, as seen from a lattice.
struct MeshFaces {
    std::span<const Vec3> positions;  ///< of the vertices
    std::span<const Triangle> triangles;
    const LatticeView& lattice;

    const Vec3& position(std::uint32_t vertex) const { return positions[vertex]; }
    std::array<Vec3, 3> corners(std::size_t face) const {
        const auto& [a, b, c] = triangles[face];
        return {position(a), position(b), position(c)};
    }
    TriangleFrame frame(std::size_t face) const { return triangle_frame(corners(face), lattice); }
};

}  // namespace clsdf::polyhedra

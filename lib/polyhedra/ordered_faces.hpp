#pragma once

#include "core/uninitialized_vector.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The faces of a mesh in another order, and its vertices numbered as those faces first name them, without those that
/// none names: what is near in one list is near in the others.
struct OrderedFaces {
    /// Faces of a stretch, no more than the caches hold with all that is made of them.
    static constexpr std::size_t stretch = 3072;

    UninitializedVector<Triangle> triangles;
    UninitializedVector<std::uint32_t> vertices;  ///< the mesh's index of each
    /// Of each stretch the first of the vertices that it names and none before it does; then the number of vertices.
    std::vector<std::uint32_t> first_vertices;
};

/// `order`: the mesh's index of each face. Throws Error(unsupported) for 2^30 faces or more.
OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order);

}  // namespace clsdf::polyhedra

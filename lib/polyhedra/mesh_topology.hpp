#pragma once

#include <clsdf/mesh.hpp>

#include "core/uninitialized_vector.hpp"
#include "polyhedra/edges.hpp"
#include "polyhedra/one_rings.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The faces of a mesh in another order. Its vertices are numbered as those faces first name them, without unused ones,
/// so neighbours in one list are near each other in the others.
struct OrderedFaces {
    /// Faces of a sub-range; they fit the caches with all data that is made from them.
    static constexpr std::size_t stretch = 3072;

    UninitializedVector<Triangle> triangles;
    UninitializedVector<std::uint32_t> vertices;  ///< the mesh's index of each
    /// For each sub-range, the first vertex that it names and no earlier one does; then the number of vertices.
    std::vector<std::uint32_t> first_vertices;
};

/// `order`: the mesh's index of each face. Throws Error(unsupported) for 2^30 faces or more.
OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order);

/// The data that follow from a mesh's triangles. The order of the faces also depends on the first positions of the
/// vertices; later positions do not change it.
struct MeshTopology {
    UninitializedVector<std::uint32_t> order;  ///< the mesh's index of each face, in Morton order
    OrderedFaces faces;
    OneRings rings;
    PairedEdges edges;

    /// Throws Error(unsupported) for 2^30 faces or more.
    explicit MeshTopology(const Mesh& mesh);
    /// In another order: the mesh's index of each face.
    MeshTopology(const Mesh& mesh, UninitializedVector<std::uint32_t> order);

    std::size_t bytes() const;
};

}  // namespace clsdf::polyhedra

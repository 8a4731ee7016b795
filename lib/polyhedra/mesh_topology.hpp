#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/ordered_faces.hpp"
#include "polyhedra/pair_edges.hpp"

#include <cstddef>
#include <cstdint>

namespace clsdf::polyhedra {

/// The data that follow from a mesh's triangles. The order of the faces also depends on the first positions of the
/// vertices; later positions do not change it.
struct MeshTopology {
    UninitializedVector<std::uint32_t> order;  ///< the mesh's index of each face, in Morton order
    OrderedFaces faces;
    OneRings rings;
    PairedEdges edges;

    /// Throws Error(unsupported) for 2^30 faces or more.
    explicit MeshTopology(const Mesh& mesh);

    std::size_t bytes() const;
};

}  // namespace clsdf::polyhedra

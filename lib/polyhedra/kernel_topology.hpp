#pragma once

#include "face_sources.h"
#include "polyhedra/mesh_topology.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf::polyhedra {

/// A mesh's topology as the kernels that make polyhedra read it (kernels/mesh_records.cl), and what they leave out.
struct KernelTopology {
    /// Three of each face: the vertex of the other face that lies opposite to edge k; CLSDF_NO_VERTEX unless the edge
    /// has exactly two faces, of one orientation.
    UninitializedVector<std::uint32_t> opposite;
    /// The caller's index of each face, with CLSDF_NAME_NON_MANIFOLD.
    UninitializedVector<std::uint32_t> names;
    UninitializedVector<std::uint32_t> fan_words;  ///< see FanItem
    std::vector<FanItem> fan_items;
    /// Ascending: faces with an edge of three faces or more, of two of different orientations, or from a vertex to
    /// itself.
    std::vector<std::uint32_t> awkward_faces;
    /// Ascending: vertices that are in no fan, and may leave a gap.
    std::vector<std::uint32_t> awkward_vertices;
    /// Ascending: vertices at an open edge, which leave none.
    std::vector<std::uint32_t> border_vertices;

    explicit KernelTopology(const MeshTopology& topology);

    std::size_t bytes() const;
};

}  // namespace clsdf::polyhedra

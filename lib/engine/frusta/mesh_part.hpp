#pragma once

#include "frusta/cluster_index.hpp"
#include "frusta/frusta.hpp"
#include "surface/sign_surface.hpp"
#include "topology/topology.hpp"

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <memory>
#include <vector>

namespace clsdf::engine {

/// A part of a mesh's triangles, with the polyhedra that they have in the whole mesh.
struct MeshPart {
    Mesh mesh;                             ///< its triangles and vertices ascend as in the whole, and it has its box
    SignSurface surface;                   ///< the part of the whole mesh's
    std::vector<std::uint32_t> triangles;  ///< of each triangle, its index in the whole
    std::shared_ptr<const MeshTopology> topology;
    Frusta frusta;
};

/// Whole clusters of faces (ClusterIndex) and whole groups of point sites, so that clusters and groups of the part are
/// those of the whole. Ranges of faces may overlap; those of the point sites' vertices are added. `mesh`: with its
/// present positions.
MeshPart part_of(const Mesh& mesh, const SignSurface& surface, const MeshTopology& topology, const Frusta& frusta,
                 const NearRecords& near);

}  // namespace clsdf::engine

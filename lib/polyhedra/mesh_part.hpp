#pragma once

#include <clsdf/mesh.hpp>

#include "polyhedra/cluster_index.hpp"
#include "polyhedra/frusta.hpp"
#include "polyhedra/topology.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace clsdf::polyhedra {

/// Some of a mesh's triangles, with the polyhedra that they have in the whole mesh.
struct MeshPart {
    Mesh mesh;                             ///< its triangles and vertices ascend as in the whole, and it has its box
    std::vector<std::uint32_t> triangles;  ///< of each triangle, its index in the whole
    std::shared_ptr<const MeshTopology> topology;
    Frusta frusta;
};

/// Whole clusters of faces (ClusterIndex) and whole groups of point sites, so that clusters and groups of the part are
/// those of the whole. Ranges of faces may overlap; those of the point sites' vertices are added. `mesh`: with its
/// present positions.
MeshPart part_of(const Mesh& mesh, const MeshTopology& topology, const Frusta& frusta, const NearRecords& near);

/// As mesh.move(), without a look at the triangles. `topology`: the mesh's.
void move(Mesh& mesh, const MeshTopology& topology, std::vector<Vec3> positions);

}  // namespace clsdf::polyhedra

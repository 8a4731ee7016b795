#pragma once

#include "frusta/cluster_index.hpp"
#include "frusta/frusta.hpp"
#include "surface/sign_surface.hpp"
#include "topology/topology.hpp"

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::engine {

/// A part of a mesh's triangles, with the polyhedra that they have in the whole mesh.
struct MeshPart {
    Mesh mesh;                             ///< its triangles and vertices ascend as in the whole, and it has its box
    SignSurface surface;                   ///< the part of the whole mesh's
    std::vector<std::uint32_t> triangles;  ///< of each triangle, its index in the whole
    std::shared_ptr<const MeshTopology> topology;
    Frusta frusta;
    std::vector<std::uint32_t> vertices{};  ///< of each vertex, its index in the whole; of part_of() alone
};

/// A part with its topology and its vertices' positions in that, and without the other members of its frusta. order: of
/// its triangles, as in MeshTopology. non_manifold: edges of ordered faces, 3 face + edge, that have three faces or
/// more in the whole mesh. box: of the whole mesh.
MeshPart make_part(Mesh mesh, const Box& box, SignSurface surface, std::vector<std::uint32_t> triangles,
                   UninitializedVector<std::uint32_t> order, std::span<const std::uint32_t> non_manifold);
/// The edges that a part has to be made again with.
std::vector<std::uint32_t> non_manifold_edges(const MeshTopology& topology);

/// Whole clusters of faces (ClusterIndex) and whole groups of point sites, so that clusters and groups of the part are
/// those of the whole. Ranges of faces may overlap; those of the point sites' vertices are added. `mesh`: with its
/// present positions.
MeshPart part_of(const Mesh& mesh, const SignSurface& surface, const MeshTopology& topology, const Frusta& frusta,
                 const NearRecords& near);

}  // namespace clsdf::engine

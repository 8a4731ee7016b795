#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "frusta/cluster_index.hpp"
#include "frusta/frusta.hpp"
#include "topology/topology.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::engine {

/// Several meshes as one, for kernels: a launch takes all of them, or those that are selected. Each keeps the order of
/// its faces, and its records keep their groups (record_group), so fields of a mesh have the bytes that it has alone.
struct JoinedMeshes {
    Mesh mesh;  ///< one after the other; the last face of each fills up its last group of records
    std::shared_ptr<const MeshTopology> topology;
    std::vector<std::uint32_t> numbers;  ///< of the triangles, in their own mesh
};

struct MeshToJoin {
    const Mesh* mesh;
    std::shared_ptr<const MeshTopology> topology;
};

/// positions: of the vertices of all meshes, one after the other. Throws as the constructor of Mesh.
JoinedMeshes join_meshes(std::span<const MeshToJoin> meshes, std::vector<Vec3> positions);

/// Whether joined meshes in this box have the bytes of single ones in a field: if lists bound distances alike for all,
/// and no coordinate needs the host.
bool can_be_joined(const Box& box, const Grid& grid, const Band& band, SignRule sign);

/// The records of some of the meshes, whose numbers ascend, without faces that only fill up groups.
NearRecords records_of_meshes(const MeshTopology& joined, const FoundFrusta& frusta,
                              std::span<const std::uint32_t> meshes);

}  // namespace clsdf::engine

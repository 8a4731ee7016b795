#pragma once

#include "frusta/frusta.hpp"
#include "frusta/records.hpp"
#include "frusta/topology.hpp"
#include "mesh/mesh_arrays.hpp"
#include "mesh/sign_surface.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::engine {

/// Consecutive faces, or point sites: neighbours, because both are in Morton order.
struct RecordRange {
    std::size_t begin = 0;
    std::size_t end = 0;
};

/// The records near a box, in whole groups (record_group).
struct NearRecords {
    std::vector<RecordRange> faces;  ///< ascending; each begins at a multiple of record_group
    std::vector<RecordRange> sites;
    std::size_t face_count = 0;
    std::size_t site_count = 0;

    std::size_t host_bytes() const { return (faces.size() + sites.size()) * sizeof(RecordRange); }
};

/// Boxes around clusters of faces and of point sites, and around superclusters of clusters.
///
/// A cluster's box, in the mesh's units, holds a ball around each of its faces: its centre is the foot of the altitude
/// on the longest edge, and it holds the face. The kernels test the same balls; a box includes their rounding.
class ClusterIndex {
public:
    /// Faces of a cluster, and clusters of a supercluster.
    static constexpr std::size_t cluster = CLSDF_CLUSTER;
    static constexpr std::size_t supercluster = 16;

    /// clusters: cluster_boxes() of so many faces, or the kernel's. of_sites: the point sites, and their positions.
    ClusterIndex(std::size_t face_count, std::vector<Box> clusters, const Frusta& of_sites);

    /// Clusters whose boxes overlap one of the given ones.
    NearRecords near(std::span<const Box> boxes) const;
    NearRecords near(const Box& box) const { return near({&box, 1}); }

    std::size_t host_bytes() const { return (clusters_.size() + superclusters_.size() + sites_.size()) * sizeof(Box); }

private:
    std::size_t face_count_;
    std::size_t site_count_;
    std::vector<Box> clusters_;
    std::vector<Box> superclusters_;
    std::vector<Box> sites_;  // of record_group point sites each
};

/// Boxes around all balls of each cluster, and its faces, without rounding.
std::vector<Box> cluster_boxes(std::span<const Triangle> triangles, std::span<const Vec3> positions);

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

/// A mesh whose arrays are on the device; it has the name that a MeshView's has.
Mesh mesh_without_arrays(const Box& box);
/// Its arrays; name and box stay.
void set_arrays(Mesh& mesh, MeshArrays arrays);

/// As mesh.set_positions(), without a look at the triangles. `topology`: the mesh's.
void move(Mesh& mesh, const MeshTopology& topology, std::vector<Vec3> positions);
/// The same of finite positions of the vertices in use, whose box is known; or of their box alone.
void move(Mesh& mesh, const Box& box, std::vector<Vec3> positions);
void move(Mesh& mesh, const Box& box);
/// The positions that belong to the box, of the vertices in use. `ordered`: as the topology numbers them.
void set_ordered_positions(Mesh& mesh, const MeshTopology& topology, std::span<const Vec3> ordered);

}  // namespace clsdf::engine

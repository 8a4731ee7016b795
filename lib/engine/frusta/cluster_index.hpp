#pragma once

#include "frusta/frusta.hpp"
#include "frusta/records.hpp"
#include "topology/topology.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
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

}  // namespace clsdf::engine

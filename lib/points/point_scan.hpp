#pragma once

#include "device/buffer_pool.hpp"
#include "frusta/prepared_mesh.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"
#include "point_groups.h"
#include "tree/point_mesh.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

namespace clsdf::points {

/// The part of a mesh that the scan of many points reads beside the tree.
struct ScannedMesh {
    ScanCounts counts{};
    device::BufferPool::Lease records;        ///< ScanRecord
    device::BufferPool::Lease neighbours;     ///< FaceNeighbours, of each face
    device::BufferPool::Lease ring_starts;    ///< of each vertex in ring_faces, and the end
    device::BufferPool::Lease ring_faces;     ///< the faces at each vertex
    device::BufferPool::Lease site_vertices;  ///< the vertex of each point site

    std::size_t device_bytes() const {
        return records.bytes() + neighbours.bytes() + ring_starts.bytes() + ring_faces.bytes() + site_vertices.bytes();
    }
};

/// `polyhedra`: of all faces and point sites, for PointMesh::lattice, which are not needed any
/// more. Throws Error(out_of_memory).
ScannedMesh make_scanned_mesh(const engine::DeviceTools& tools, const engine::PointMesh& mesh,
                              const engine::Frusta& frusta, const engine::PreparedMesh& polyhedra);

/// Whether points are scanned in groups rather than looked up one by one. The results are the same.
bool is_scan_worthwhile(const engine::Programs& programs, std::size_t points, std::size_t faces);

/// Groups of points that follow each other (kernels/points/point_groups.h), from bricks up.
struct PointGroups {
    UninitializedVector<PointGroup> bricks, blocks, superblocks;
};

/// Points in units, in the order of a curve.
PointGroups group_points(std::span<const Vec3> in_units);

/// Points for the scan.
struct ScanJob {
    engine::DeviceTools tools;
    const engine::PointFaces& mesh;
    const ScannedMesh& scanned;
    const PointGroups& groups;
    std::size_t count;
    const cl::Buffer& points;  ///< in units, in the order of a curve
    double most;               ///< a squared distance in units beyond which nothing is looked for
};

/// Writes the nearest face of each point, and its squared distance in units. `between`, which may be empty and may
/// throw, is called between launches with the fraction done.
void scan_points(const ScanJob& job, const cl::Buffer& faces, const cl::Buffer& squared,
                 const std::function<void(double)>& between);

}  // namespace clsdf::points

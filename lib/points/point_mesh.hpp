#pragma once

#include <clsdf/mesh.hpp>

#include "core/uninitialized_vector.hpp"
#include "device/buffer_pool.hpp"
#include "point_tree.h"
#include "polyhedra/mesh_topology.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <cstddef>
#include <memory>
#include <vector>

/// Distances at points anywhere.
namespace clsdf::points {

/// The lattice that points are measured in: its origin is the lower corner of the mesh's box, its unit the greatest
/// power of two not above 1/256 of the box's longest side, or 1 if the mesh has no extent. Throws
/// Error(invalid_argument) if a float cannot hold the unit.
polyhedra::LatticeView lattice_for_points(const Mesh& mesh);

/// A mesh as searches for the nearest triangle of a point read it, on the device and, for signs, on the host. It
/// follows from the triangles and the positions alone.
struct PointMesh {
    polyhedra::LatticeView lattice;
    Box box;                                                  ///< of the mesh
    std::shared_ptr<const polyhedra::MeshTopology> topology;  ///< whose faces the tree's faces are
    UninitializedVector<Vec3> positions;                      ///< of the vertices, numbered as in MeshTopology::faces
    PointTree tree{};
    std::vector<PointNode> nodes;  ///< level by level; the root is the last

    device::BufferPool::Lease device_nodes;  ///< the same
    device::BufferPool::Lease leaves;        ///< PointLeaf
    device::BufferPool::Lease polyhedra;     ///< Polyhedron, of each face, with frames and without slopes

    std::size_t face_count() const { return topology->order.size(); }
    std::array<Vec3, 3> corners(std::size_t face) const {
        const auto& [a, b, c] = topology->faces.triangles[face];
        return {positions[a], positions[b], positions[c]};
    }

    std::size_t host_bytes() const { return positions.size() * sizeof(Vec3) + nodes.size() * sizeof(PointNode); }
    std::size_t device_bytes() const { return device_nodes.bytes() + leaves.bytes() + polyhedra.bytes(); }
};

/// Throws Error(invalid_argument or out_of_memory).
PointMesh make_point_mesh(device::Context& context, const std::shared_ptr<device::BufferPool>& pool, const Mesh& mesh,
                          std::shared_ptr<const polyhedra::MeshTopology> topology);

}  // namespace clsdf::points

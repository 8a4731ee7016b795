#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "homes/device_set_up.hpp"
#include "homes/homed.hpp"
#include "mesh/mesh_arrays.hpp"
#include "mesh_topology.h"
#include "topology/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::engine {

/// The faces of a mesh on the device, in their order, with their names: the data that moving vertices leave as they
/// are.
struct NamedFaces {
    std::size_t face_count = 0;
    std::size_t vertex_count = 0;
    std::shared_ptr<const MeshTopology> topology;  ///< whose arrays are shared; null if a GPU has made the names
    device::BufferPool::Lease triangles;           ///< Triangle, numbers of vertices as in MeshTopology::faces
    device::BufferPool::Lease names;               ///< see face_edges.h

    std::size_t device_bytes() const { return triangles.bytes() + names.bytes(); }
};

NamedFaces device_names(const DeviceSetUp& set_up, std::shared_ptr<const MeshTopology> topology);

/// The first vertex of equal coordinates of each of the caller's vertices.
struct EqualVertices {
    device::BufferPool::Lease first;  ///< with CLSDF_IN_USE
    std::size_t count = 0;

    /// The same on the host, without marks. Waits. Throws Error.
    std::vector<std::uint32_t> read(const DeviceSetUp& set_up) const;
    std::size_t device_bytes() const { return first.bytes(); }
};

/// The topology of a mesh in memory of a GPU: the bytes of MeshTopology and of opposite_words(), by
/// kernels/topology/mesh_topology.cl or from the host. The host reads it back when it needs it.
struct DeviceTopology {
    std::shared_ptr<const NamedFaces> names;
    device::BufferPool::Lease order;
    device::BufferPool::Lease vertices;  ///< the given vertex of each vertex
    device::BufferPool::Lease starts;    ///< of each vertex in `corners`, and the end of the last
    device::BufferPool::Lease corners;   ///< packed
    device::BufferPool::Lease edges;     ///< FaceEdges
    device::BufferPool::Lease opposite;
    std::shared_ptr<const EqualVertices> equal{};  ///< among the given ones; null if no two are equal
    bool are_paired = false;                       ///< as PairedEdges
    bool has_irregular = true;                     ///< whether an edge may have another mark than edge_open

    std::size_t face_count() const { return names->face_count; }
    std::size_t vertex_count() const { return names->vertex_count; }

    /// The same on the host. numbers: those of the given vertices in the host's mesh; empty if they are the same.
    /// Waits. Throws Error.
    MeshTopology read(const DeviceSetUp& set_up, std::span<const std::uint32_t> numbers) const;

    /// Without the names.
    std::size_t device_bytes() const;
};
/// The topology of a mesh on the host, on the device or on both.
using HomedTopology = Homed<MeshTopology, DeviceTopology>;

/// An array of the caller's in memory of the device.
struct DeviceTriples {
    cl::Buffer memory;
    std::size_t count = 0;  ///< of items
    GivenTriples steps{};
};
/// The same of memory of the device. Throws cl::Error.
DeviceTriples device_triples(const InputArray& array);

/// A copy of the caller's mesh in memory of the device.
struct DeviceMesh {
    device::BufferPool::Lease vertices;   ///< Vec3
    device::BufferPool::Lease triangles;  ///< Triangle
    std::size_t vertex_count = 0;
    std::size_t face_count = 0;

    /// The same on the host. Waits. Throws Error.
    MeshArrays read(const DeviceSetUp& set_up) const;
    std::size_t device_bytes() const { return vertices.bytes() + triangles.bytes(); }
};

/// The topology that the kernels have made, and what else they have found.
struct MadeTopology {
    std::shared_ptr<const DeviceTopology> topology;
    TopologyResults results{};
    std::shared_ptr<const DeviceMesh> mesh{};  ///< the caller's, if the host does not have it
    std::size_t given_vertices = 0;            ///< of the caller's mesh
    device::BufferPool::Lease positions;       ///< Vec3 of each vertex of the topology, as given

    /// Whether all faces are joined over vertices.
    bool is_one_part() const { return results.joined_vertices + 1 >= results.vertex_count; }
    bool encloses_negative_volume() const;
    Box box() const;
};

/// The topology of a mesh by kernels; nothing if the mesh is beyond their limits. Waits once. Throws
/// Error(out_of_memory or device_failure).
std::optional<MadeTopology> make_device_topology(const DeviceSetUp& set_up, const Mesh& mesh);
/// The same of a mesh in memory of the device; also nothing if it is no mesh (Mesh).
std::optional<MadeTopology> make_device_topology(const DeviceSetUp& set_up, const DeviceTriples& vertices,
                                                 const DeviceTriples& triangles);

struct MovedVertices {
    device::BufferPool::Lease positions;  ///< Vec3 of each vertex of the topology
    Box box;
    /// If not, the host looks at the positions: they are not finite, or equal vertices move apart.
    bool are_usable = true;
};

/// New positions of the given vertices that are in use. Waits once. Throws Error.
MovedVertices move_vertices(const DeviceSetUp& set_up, const DeviceTopology& topology, const DeviceTriples& positions);
MovedVertices move_vertices(const DeviceSetUp& set_up, const DeviceTopology& topology, std::span<const Vec3> positions);

/// The host's topology, in memory of the device.
DeviceTopology device_topology(const DeviceSetUp& set_up, std::shared_ptr<const NamedFaces> names,
                               const MeshTopology& topology);

}  // namespace clsdf::engine

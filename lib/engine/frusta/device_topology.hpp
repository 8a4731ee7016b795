#pragma once

#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "device/in_flight.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/topology.hpp"
#include "mesh_topology.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::engine {

/// The topology of a mesh in memory of a GPU: the bytes of MeshTopology and of opposite_words(), by
/// kernels/frusta/mesh_topology.cl or from the host. The host reads it back when it needs it.
struct DeviceTopology {
    std::shared_ptr<const DeviceFaces::Names> names;
    device::BufferPool::Lease order;
    device::BufferPool::Lease vertices;  ///< the given vertex of each vertex
    device::BufferPool::Lease starts;    ///< of each vertex in `corners`, and the end of the last
    device::BufferPool::Lease corners;   ///< packed
    device::BufferPool::Lease edges;     ///< FaceEdges
    device::BufferPool::Lease opposite;
    bool are_paired = false;    ///< as PairedEdges
    bool has_irregular = true;  ///< whether an edge may have another mark than edge_open

    std::size_t face_count() const { return names->face_count; }
    std::size_t vertex_count() const { return names->vertex_count; }

    /// The same on the host. numbers: those of the given vertices in the host's mesh; empty if they are the same.
    /// Waits. Throws Error.
    MeshTopology read(const DeviceSetUp& job, std::span<const std::uint32_t> numbers) const;

    /// Without the names.
    std::size_t device_bytes() const;
};

/// The topology that the kernels have made, and what else they have found.
struct MadeTopology {
    std::shared_ptr<const DeviceTopology> topology;
    TopologyResults results{};
    std::size_t given_vertices = 0;         ///< of the caller's mesh
    device::BufferPool::Lease first_equal;  ///< of each given vertex; empty unless vertices count as one
    device::BufferPool::Lease positions;    ///< Vec3 of each vertex of the topology, as given

    /// Whether vertices of equal coordinates count as one.
    bool has_equal_vertices() const { return results.used_vertices != results.different_vertices; }
    /// Whether all faces are joined over vertices.
    bool is_one_part() const { return results.joined_vertices + 1 >= results.vertex_count; }
    bool encloses_negative_volume() const;

    /// The first vertex of equal coordinates of each given one. Waits. Throws Error.
    std::vector<std::uint32_t> read_first_equal(const DeviceSetUp& job) const;
};

/// Reads a value from the beginning of a buffer. Waits. Throws cl::Error, also if a kernel has failed.
template <class Value>
Value read_value(const DeviceTools& tools, const cl::Buffer& buffer) {
    device::InFlight<Value> value(tools.context);
    value.begin();
    cl::Event is_read;  // a blocking read by PoCL does not fail if a kernel has
    tools.queue().enqueueReadBuffer(buffer, CL_FALSE, 0, sizeof(Value), &*value, nullptr, &is_read);
    is_read.wait();
    value.end();
    return *value;
}

/// Whether a device makes the topology of a mesh: it has memory of its own and runs the body by_group, and the mesh is
/// so large that the host would take longer.
bool suits_device_topology(const DeviceTools& tools, const Mesh& mesh);

/// The topology of a mesh by kernels; nothing if the mesh is beyond their limits. Waits once. Throws
/// Error(out_of_memory or device_failure).
std::optional<MadeTopology> make_device_topology(const DeviceSetUp& job, const Mesh& mesh);

/// Positions of the caller's vertices in memory of the device, as doubles.
struct DevicePositions {
    cl::Buffer memory;
    std::size_t count = 0;
    std::size_t first = 0;         ///< number of the first one's x in the memory
    std::ptrdiff_t triple = 3;     ///< numbers from a position to the next one
    std::ptrdiff_t component = 1;  ///< and from x to y, from y to z
};

struct MovedVertices {
    device::BufferPool::Lease positions;  ///< Vec3 of each vertex of the topology
    Box box;
    bool are_finite = true;  ///< if not, the box has no meaning
};

/// New positions of the vertices that are in use. Waits once. Throws Error.
MovedVertices move_vertices(const DeviceSetUp& job, const DeviceTopology& topology, const DevicePositions& positions);
MovedVertices move_vertices(const DeviceSetUp& job, const DeviceTopology& topology, const std::vector<Vec3>& positions);

/// The host's topology, in memory of the device.
DeviceTopology device_topology(const DeviceSetUp& job, std::shared_ptr<const DeviceFaces::Names> names,
                               const MeshTopology& topology);

}  // namespace clsdf::engine

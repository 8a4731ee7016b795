#pragma once

#include "device/buffer_pool.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/frusta.hpp"
#include "frusta/kernel_topology.hpp"
#include "frusta/prepared_mesh.hpp"
#include "topology/device_topology.hpp"

#include <cstddef>
#include <memory>
#include <optional>

namespace clsdf::engine {

/// A mesh's topology, which the host has found, for the kernels that make frusta.
struct FrustaSources {
    std::shared_ptr<const KernelTopology> of_kernels;
    device::BufferPool::Lease opposite, fan_words, fan_items;

    FrustaSources(const DeviceSetUp& set_up, const MeshTopology& topology);

    std::size_t host_bytes() const { return of_kernels->host_bytes(); }
    std::size_t device_bytes() const { return opposite.bytes() + fan_words.bytes() + fan_items.bytes(); }
};

/// The frusta of a mesh on the host, on the device or on both.
using HomedFrusta = Homed<Frusta, DeviceFaces>;

struct MadeFrusta {
    /// Null if faces.part is set: positions and slopes are on the device alone. The faces share its arrays if device
    /// and host share their memory.
    std::shared_ptr<const Frusta> frusta;
    DeviceFaces faces;
    std::optional<PreparedMesh> records{};  ///< for the lattice, if there is one
    LeftToHost left{};                      ///< decisions that the host has made
};

/// The frusta of a mesh with these faces: made by kernels, and completed by the host, exactly. `lattice`: whose records
/// are made, too; null for none. One wait for the device.
MadeFrusta frusta_by_kernels(const DeviceSetUp& set_up, const std::shared_ptr<const NamedFaces>& names,
                             const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh,
                             const LatticeView* lattice);

/// The same on a device that has its own arrays. `positions`: Vec3 of each vertex of the topology. If kernels leave
/// much to the host, the topology comes to the host, and the whole is completed there. Two waits otherwise.
MadeFrusta frusta_by_kernels(const DeviceSetUp& set_up, HomedTopology& topology,
                             std::shared_ptr<const device::BufferPool::Lease> positions, const Box& box,
                             const LatticeView* lattice);

}  // namespace clsdf::engine

#pragma once

#include "device/buffer_pool.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/device_topology.hpp"
#include "frusta/frusta.hpp"
#include "frusta/kernel_topology.hpp"
#include "frusta/prepared_mesh.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

namespace clsdf::engine {

/// A mesh's topology, which the host has found, for the kernels that make frusta.
struct FrustaSources {
    std::shared_ptr<const KernelTopology> of_kernels;
    device::BufferPool::Lease opposite, fan_words, fan_items;

    FrustaSources(const DeviceSetUp& job, const MeshTopology& topology);

    std::size_t host_bytes() const { return of_kernels->host_bytes(); }
    std::size_t device_bytes() const { return opposite.bytes() + fan_words.bytes() + fan_items.bytes(); }
};

/// Whether so many faces are few enough for the kernels' numbers.
bool suits_kernels(std::size_t faces);

struct MadeFrusta {
    /// Without positions and slopes if faces.part is set; see fill(). Otherwise the faces share its arrays if device
    /// and host share their memory.
    std::shared_ptr<Frusta> frusta;
    DeviceFaces faces;
    std::optional<PreparedMesh> records{};  ///< for the lattice, if there is one
    LeftToHost left{};                      ///< decisions that the host has made
};

/// The frusta of a mesh with these faces: made by kernels, and completed by the host, exactly. `lattice`: whose records
/// are made, too; null for none. One wait for the device.
MadeFrusta frusta_by_kernels(const DeviceSetUp& job, const std::shared_ptr<const DeviceFaces::Names>& names,
                             const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh,
                             const LatticeView* lattice);

/// The same from the topology that a GPU has made. `positions`: Vec3 of each of its vertices. `on_host`: the topology,
/// which is asked for only if kernels leave much to the host; then the whole is completed there. Two waits otherwise.
MadeFrusta frusta_by_kernels(const DeviceSetUp& job, const DeviceTopology& topology,
                             device::BufferPool::Lease positions, const Box& box,
                             const std::function<const MeshTopology&()>& on_host, const LatticeView* lattice);

/// Reads the positions and the slopes from the device. Waits. Throws Error.
void fill(const DeviceSetUp& job, const DeviceFaces& faces, Frusta& frusta);

}  // namespace clsdf::engine

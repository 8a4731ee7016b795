#pragma once

#include "device/buffer_pool.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/frusta.hpp"
#include "frusta/kernel_topology.hpp"
#include "frusta/prepared_mesh.hpp"

#include <cstddef>
#include <memory>
#include <optional>

namespace clsdf::engine {

/// A mesh's topology for the kernels that make frusta.
struct FrustaSources {
    std::shared_ptr<const KernelTopology> of_kernels;
    device::BufferPool::Lease opposite, fan_words, fan_items;

    FrustaSources(const DeviceSetUp& job, const MeshTopology& topology);

    std::size_t host_bytes() const { return of_kernels->host_bytes(); }
    std::size_t device_bytes() const { return opposite.bytes() + fan_words.bytes() + fan_items.bytes(); }
};

/// Whether the topology has few enough faces for the kernels' numbers.
bool suits_kernels(const MeshTopology& topology);

struct MadeFrusta {
    /// The faces share its arrays if device and host share their memory.
    std::shared_ptr<const Frusta> frusta;
    DeviceFaces faces;
    std::optional<PreparedMesh> records{};  ///< for the lattice, if there is one
    LeftToHost left{};                      ///< decisions that the host has made
};

/// The frusta of a mesh with these faces: made by kernels, and completed by the host, exactly. One wait for the device.
/// `lattice`: whose records are made, too; null for none.
MadeFrusta frusta_by_kernels(const DeviceSetUp& job, const std::shared_ptr<const DeviceFaces::Names>& names,
                             const std::shared_ptr<const FrustaSources>& sources, const Mesh& mesh,
                             const LatticeView* lattice);

}  // namespace clsdf::engine

#pragma once

#include "device/buffer_pool.hpp"
#include "polyhedra/complete_frusta.hpp"
#include "transform/device_faces.hpp"
#include "transform/prepared_mesh.hpp"

#include <cstddef>
#include <memory>
#include <optional>

namespace clsdf::transform {

/// A mesh's topology for the kernels of mesh_records.cl, on a processor, which reads the host's memory.
struct FrustaSources {
    std::shared_ptr<const polyhedra::MeshTopology> topology;
    polyhedra::KernelTopology of_kernels;
    device::BufferPool::Lease triangles, opposite, names, fan_words, fan_items;

    FrustaSources(device::Context& context, std::shared_ptr<const polyhedra::MeshTopology> topology_in);

    std::size_t bytes() const { return of_kernels.bytes(); }
};

/// Arrays that moves of the vertices leave to the next time.
struct FrustaMemory {
    polyhedra::CompletionMemory completion;
    UninitializedVector<float> signs;
    UninitializedVector<std::uint8_t> face_answers;
    UninitializedVector<std::uint8_t> vertex_answers;

    std::size_t bytes() const {
        return completion.bytes() + signs.size() * sizeof(float) + face_answers.size() + vertex_answers.size();
    }
};

/// Whether kernels make a mesh's frusta: not of few triangles, which the host has made before it has woken the device.
bool suits_kernels(const polyhedra::MeshTopology& topology, std::size_t least_faces);

/// The frusta, made by kernels and completed by the host; and their records for a lattice, unless it is null.
/// `records` is set then. Returns nothing if too many faces are nearly degenerate: see complete_frusta().
std::optional<polyhedra::Frusta> frusta_by_kernels(const DeviceSetUp& job,
                                                   const std::shared_ptr<const FrustaSources>& sources,
                                                   FrustaMemory& memory, const Mesh& mesh,
                                                   const polyhedra::LatticeView* lattice, PreparedMesh* records);

}  // namespace clsdf::transform

#pragma once

#include "device/buffer_pool.hpp"
#include "face_sources.h"
#include "polyhedra/cluster_index.hpp"
#include "polyhedra/frusta.hpp"
#include "polyhedra/mesh_topology.hpp"
#include "transform/prepared_mesh.hpp"

#include <cstddef>
#include <memory>
#include <span>

namespace clsdf::transform {

/// A mesh on a device with memory of its own. Records and the vertices of the sign's sweep are made of it there, for
/// each lattice: it takes a seventh of the records' bytes.
struct DeviceFaces {
    /// What moving vertices leave as it is.
    struct Names {
        device::BufferPool::Lease triangles;  ///< Triangle, numbers of vertices as in MeshTopology::faces
        device::BufferPool::Lease names;      ///< see face_sources.h
        std::size_t face_count = 0;
        std::size_t vertex_count = 0;
    };

    std::shared_ptr<const Names> names;
    device::BufferPool::Lease positions;  ///< Vec3 of each vertex
    device::BufferPool::Lease slopes;     ///< polyhedra::FaceSlopes of each face

    std::size_t bytes() const {
        return names->triangles.bytes() + names->names.bytes() + positions.bytes() + slopes.bytes();
    }
};

/// What makes them: the program of kernels/mesh_records.cl, for vectors of so many lanes.
struct DeviceSetUp {
    device::Context& context;
    const std::shared_ptr<device::BufferPool>& pool;
    const cl::Program& program;
    std::size_t lanes;

    /// Faces of a work-item.
    std::size_t item_faces() const { return lanes == 1 ? 1 : 256; }
    /// Enqueues a kernel for so many faces.
    void enqueue(const cl::Kernel& kernel, std::size_t faces) const;
};

DeviceFaces::Names upload_names(const DeviceSetUp& job, const polyhedra::MeshTopology& topology);
DeviceFaces upload_faces(const DeviceSetUp& job, std::shared_ptr<const DeviceFaces::Names> names,
                         const polyhedra::Frusta& frusta);

/// Whether the kernels' plain arithmetic suffices for a lattice: the mesh is not far from its sample (0, 0, 0), and not
/// vanishingly small beside a voxel. It is a function of mesh and lattice alone.
bool is_plain(const Mesh& mesh, const polyhedra::LatticeView& lattice);

/// A lattice as the kernels take it.
FaceLattice face_lattice(const polyhedra::LatticeView& lattice);

/// The records of ranges of faces, each of which begins with a group (polyhedra::record_group), and of point sites.
PreparedMesh records_on_device(const DeviceSetUp& job, const DeviceFaces& faces,
                               const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                               const polyhedra::LatticeView& lattice, std::span<const polyhedra::RecordRange> of_faces,
                               std::span<const polyhedra::RecordRange> of_sites);

}  // namespace clsdf::transform

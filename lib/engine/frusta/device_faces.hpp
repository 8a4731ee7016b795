#pragma once

#include "device/buffer_pool.hpp"
#include "face_sources.h"
#include "frusta/cluster_index.hpp"
#include "frusta/frusta.hpp"
#include "frusta/prepared_mesh.hpp"
#include "frusta/topology.hpp"
#include "launch/commands.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::engine {

struct HostPart;

/// An upper estimate of a core's time for the record or the slopes of a face; it limits the work of a launch.
inline constexpr double seconds_per_face = 1e-6;

/// Makes data of a mesh on the device, by the program of kernels/frusta/face_records.cl.
struct DeviceSetUp {
    DeviceTools tools;

    /// Faces of a work-item.
    std::size_t item_faces() const { return tools.programs.mesh_lanes() == 1 ? 1 : 256; }
    /// The launch of a kernel for so many faces.
    WorkItems items_of(std::size_t faces) const {
        return {(faces + item_faces() - 1) / item_faces(), item_faces() == 1 ? common_group : 1};
    }

    /// Whether kernels use arrays of the host in place.
    bool shares_memory() const { return tools.context.capabilities().is_processor; }
    /// A buffer in an array of the host; it has no bytes of its own. It keeps `owner` alive, which has the array.
    template <class Values>
    device::BufferPool::Lease shared(const std::shared_ptr<const void>& owner, const Values& values,
                                     cl_mem_flags access = CL_MEM_READ_ONLY) const {
        if (values.empty()) return {};
        const std::shared_ptr<const void> memory(owner, values.data());
        const std::size_t bytes = values.size() * sizeof(values[0]);
        return {nullptr, device::guarded([&] { return device::buffer_in(tools.context, memory, bytes, access); }), 0};
    }
    /// Copies values to the device, and does not wait.
    template <class Values>
    device::BufferPool::Lease upload(const Values& values, const char* purpose) const {
        return values.empty() ? device::BufferPool::Lease()
                              : device::uploaded(tools.context, tools.pool, values, purpose);
    }
    /// Values of `owner` that kernels read: the host's own if it shares its memory, else a copy.
    template <class Values>
    device::BufferPool::Lease input(const std::shared_ptr<const void>& owner, const Values& values,
                                    const char* purpose) const {
        return shares_memory() ? shared(owner, values) : upload(values, purpose);
    }
};

/// The faces of a mesh on the device. Records and the vertices of the sign's sweep are made of them there, for each
/// lattice. If device and host share their memory, the arrays are those of the topology and of the frusta.
struct DeviceFaces {
    /// The data that moving vertices leave as they are.
    struct Names {
        std::size_t face_count = 0;
        std::size_t vertex_count = 0;
        std::shared_ptr<const MeshTopology> topology;  ///< whose arrays are shared; null if a GPU has made the names
        device::BufferPool::Lease triangles;           ///< Triangle, numbers of vertices as in MeshTopology::faces
        device::BufferPool::Lease names;               ///< see face_sources.h

        std::size_t device_bytes() const { return triangles.bytes() + names.bytes(); }
    };

    std::shared_ptr<const Names> names;
    device::BufferPool::Lease positions;     ///< Vec3 of each vertex
    device::BufferPool::Lease slopes;        ///< FaceSlopes of each face
    std::shared_ptr<const HostPart> part{};  ///< null if the host has the topology and the frusta of the whole mesh

    /// Without the names.
    std::size_t device_bytes() const { return positions.bytes() + slopes.bytes(); }
};

DeviceFaces::Names device_names(const DeviceSetUp& job, std::shared_ptr<const MeshTopology> topology);
DeviceFaces device_faces(const DeviceSetUp& job, std::shared_ptr<const DeviceFaces::Names> names,
                         const std::shared_ptr<const Frusta>& frusta);

/// Whether the kernels' plain arithmetic suffices for a lattice: the mesh is not far from its sample (0, 0, 0), and not
/// vanishingly small beside a voxel. It is a function of mesh and lattice alone.
bool is_plain(const Mesh& mesh, const LatticeView& lattice);

void place_words(const DeviceSetUp& job, const cl::Buffer& written, const cl::Buffer& places, std::size_t count,
                 std::size_t item_words, const cl::Buffer& items);
/// Enqueues a copy of items that the host wrote to their places in an array on the device.
template <class T>
void place_items(const DeviceSetUp& job, const std::vector<T>& written, const std::vector<cl_uint>& places,
                 const cl::Buffer& items) {
    static_assert(sizeof(T) % sizeof(cl_uint) == 0);
    if (places.empty()) return;
    const auto values = job.upload(written, "data that the host writes");
    const auto numbers = job.upload(places, "their places");
    place_words(job, *values, *numbers, places.size(), sizeof(T) / sizeof(cl_uint), items);
}

/// The faces that the host writes records of: those of a mesh, or of a part of it.
struct WrittenFaces {
    const MeshTopology& topology;
    const Frusta& frusta;                      ///< with the point sites of the whole mesh
    std::span<const std::uint32_t> of_part{};  ///< ascending: the faces' numbers in the whole; empty if it is that

    /// The number of a face of the whole mesh. It must be one of these.
    std::size_t number_of(std::uint32_t face) const {
        if (of_part.empty()) return face;
        return static_cast<std::size_t>(std::ranges::lower_bound(of_part, face) - of_part.begin());
    }
};

/// Records that the host writes into those on the device: of faces that are nearly degenerate, and of point sites.
class WrittenRecords {
public:
    /// `faces`: those of the host, ascending, by their numbers in the whole mesh.
    WrittenRecords(const WrittenFaces& from, const LatticeView& lattice, std::span<const std::uint32_t> faces)
        : from_(from), lattice_(lattice), faces_(faces) {}

    /// Adds a range of faces, whose records begin at `record`. The last face of the mesh fills up its
    /// group.
    void add_faces(const RecordRange& range, std::size_t record);
    void add_sites(const RecordRange& range, std::size_t record);

    /// Enqueues their way to their places.
    void place(const DeviceSetUp& job, const cl::Buffer& records) const;

private:
    WrittenFaces from_;
    const LatticeView& lattice_;
    std::span<const std::uint32_t> faces_;
    std::vector<std::uint32_t> written_faces_;
    std::vector<cl_uint> face_places_;
    std::vector<Polyhedron> sites_;
    std::vector<cl_uint> site_places_;
};

/// The records of ranges of faces, each of which begins with a group (record_group), and of point sites.
/// `frusta`: of the whole mesh, of which only the counts and the slivers are looked at.
PreparedMesh records_on_device(const DeviceSetUp& job, const DeviceFaces& faces, const WrittenFaces& from,
                               const Frusta& frusta, const LatticeView& lattice, std::span<const RecordRange> of_faces,
                               std::span<const RecordRange> of_sites);

}  // namespace clsdf::engine

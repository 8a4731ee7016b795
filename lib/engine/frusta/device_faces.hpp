#pragma once

#include "device/buffer_pool.hpp"
#include "face_sources.h"
#include "frusta/cluster_index.hpp"
#include "frusta/frusta.hpp"
#include "frusta/prepared_mesh.hpp"
#include "homes/device_set_up.hpp"
#include "topology/device_topology.hpp"

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

/// The frusta of a mesh on the device. Records and the vertices of the sign's sweep are made of them there, for each
/// lattice. If device and host share their memory, the arrays are those of the topology and of the host's frusta.
struct DeviceFaces {
    std::shared_ptr<const NamedFaces> names;
    std::shared_ptr<const device::BufferPool::Lease> positions;  ///< Vec3 of each vertex
    device::BufferPool::Lease slopes;                            ///< FaceSlopes of each face
    std::shared_ptr<const FoundFrusta> found{};
    std::shared_ptr<const HostPart> part{};  ///< null if the host has the topology and the frusta of the whole mesh

    /// Without names and positions.
    std::size_t device_bytes() const { return slopes.bytes(); }
    /// Of what the host has found, if it has no Frusta.
    std::size_t host_bytes() const { return found ? found->host_bytes() : 0; }

    /// The same on the host. Waits. Throws Error.
    Frusta read(const DeviceSetUp& set_up) const;
};

/// `positions`: on the device; null if kernels use those of the frusta in place.
DeviceFaces device_faces(const DeviceSetUp& set_up, std::shared_ptr<const NamedFaces> names,
                         std::shared_ptr<const device::BufferPool::Lease> positions,
                         const std::shared_ptr<const Frusta>& frusta);

/// Whether the kernels' plain arithmetic suffices for a lattice: a mesh with this box is not far from its sample
/// (0, 0, 0), and not vanishingly small beside a voxel.
bool is_plain(const Box& box, const LatticeView& lattice);

void place_words(const DeviceSetUp& set_up, const cl::Buffer& written, const cl::Buffer& places, std::size_t count,
                 std::size_t item_words, const cl::Buffer& items);
/// Enqueues a copy of items that the host wrote to their places in an array on the device.
template <class T>
void place_items(const DeviceSetUp& set_up, const std::vector<T>& written, const std::vector<cl_uint>& places,
                 const cl::Buffer& items) {
    static_assert(sizeof(T) % sizeof(cl_uint) == 0);
    if (places.empty()) return;
    const auto values = set_up.upload(written, "data that the host writes");
    const auto numbers = set_up.upload(places, "their places");
    place_words(set_up, *values, *numbers, places.size(), sizeof(T) / sizeof(cl_uint), items);
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
    void place(const DeviceSetUp& set_up, const cl::Buffer& records) const;

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
PreparedMesh records_on_device(const DeviceSetUp& set_up, const DeviceFaces& faces, const WrittenFaces& from,
                               const LatticeView& lattice, std::span<const RecordRange> of_faces,
                               std::span<const RecordRange> of_sites);

/// cluster_boxes() of faces on the device. Waits. Throws Error.
std::vector<Box> cluster_boxes(const DeviceSetUp& set_up, const DeviceFaces& faces);

}  // namespace clsdf::engine

#pragma once

#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "frusta/cluster_index.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/frusta.hpp"
#include "frusta/kernel_frusta.hpp"
#include "frusta/mesh_part.hpp"
#include "homes/device_set_up.hpp"
#include "homes/homed.hpp"
#include "homes/kept.hpp"
#include "mesh/vertices.hpp"
#include "surface/terrain.hpp"
#include "topology/device_topology.hpp"
#include "topology/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::engine {

/// A prepared mesh whose large arrays are borrowed (KeptArray).
struct BorrowedMesh {
    std::string name;
    Box box;
    Vertices vertices;          ///< the caller's, as the arrays have them
    KeptArray<Vec3> positions;  ///< with one of each vertex
    KeptArray<Triangle> triangles;
    std::shared_ptr<const MeshTopology> topology;
    Frusta frusta;
    KeptArray<std::uint32_t> names;  ///< as NamedFaces has them
};

/// The mesh of a transform, and the values that follow from it alone, each on the host, on the device or on both.
///
///     given      the caller's arrays            until the host has a mesh of its own
///     first      one of each vertex, on the     of given. Vertices of equal coordinates count as one
///                host, at its first positions
///     topology   of the triangles               of first, or of given by a GPU
///     positions  the present ones               of first, until the vertices move
///     frusta     topology and positions         by kernels, completed by the host
///
/// On a processor kernels use the host's arrays in place. Positions on a GPU are numbered as the topology's vertices.
///
/// For one thread at a time, but name() and box() between moves.
class HomedMesh {
public:
    /// vertices: the caller's, as the mesh has them. all: the list of the values, which must outlive this.
    HomedMesh(KeptValues& all, const DeviceTools& tools, Mesh mesh, Vertices vertices);
    /// A GPU has made the topology of the mesh as given; null if made.mesh has the arrays.
    HomedMesh(KeptValues& all, const DeviceTools& tools, std::shared_ptr<const Mesh> given, MadeTopology made);
    /// The host has made the topology, with faces in an order of its own.
    HomedMesh(KeptValues& all, const DeviceTools& tools, Mesh mesh, std::shared_ptr<const MeshTopology> topology);
    /// A part of a mesh. Its frusta are on the host.
    HomedMesh(KeptValues& all, const DeviceTools& tools, Mesh mesh, std::shared_ptr<const MeshTopology> topology,
              Frusta frusta);
    /// Until the vertices move, it reads the borrowed arrays; only those who ask for the mesh itself get copies.
    HomedMesh(KeptValues& all, const DeviceTools& tools, BorrowedMesh mesh);
    HomedMesh(const HomedMesh&) = delete;
    HomedMesh& operator=(const HomedMesh&) = delete;

    const std::string& name() const { return name_; }
    /// At the present positions.
    const Box& box() const { return box_; }
    std::size_t face_count() const { return face_count_; }
    const DeviceSetUp& set_up() const { return set_up_; }

    /// At its present positions, with one of each vertex.
    const Mesh& on_host() { return *positions_.on_host(); }
    /// Of on_host(), without making it of borrowed arrays.
    PlacedVertices present();
    std::span<const Triangle> triangles() {
        return borrowed_ ? std::span<const Triangle>(borrowed_->triangles) : on_host().triangles();
    }
    /// Whether the vertices have moved.
    bool has_moved() const { return has_moved_; }
    /// The caller's vertices as on_host() has them.
    const Vertices& vertices() { return borrowed_ ? borrowed_->vertices : first().vertices; }
    const std::vector<Vec3>& first_positions() { return first().mesh->vertices(); }

    const MeshTopology& topology() { return *topology_.on_host(); }
    const std::shared_ptr<const MeshTopology>& shared_topology() { return topology_.on_host(); }
    const std::shared_ptr<const NamedFaces>& names();
    /// The same if they are there already; else null.
    const std::shared_ptr<const NamedFaces>& made_names() const;
    /// The present positions on the device: Vec3 of each vertex, as the names number them.
    const std::shared_ptr<const device::BufferPool::Lease>& positions_on_device() { return positions_.on_device(); }

    /// The topology on the device if kernels have made it; else null.
    std::shared_ptr<const DeviceTopology> topology_by_kernels() const {
        return set_up_.ways.topology_by_kernels ? topology_.if_on_device() : nullptr;
    }

    /// Makes the frusta, and their records for the lattice if kernels make them. lattice: may be null.
    std::optional<PreparedMesh> make_frusta(const LatticeView* lattice);
    bool has_frusta() const { return frusta_.is_made(); }
    const Frusta& frusta() { return *frusta_.on_host(); }
    const FoundFrusta& found();
    /// The frusta on the device, if kernels make the records.
    const std::shared_ptr<const DeviceFaces>& faces() { return frusta_.on_device(); }
    /// The faces that the host writes records of.
    WrittenFaces written_faces(const DeviceFaces& faces);
    /// Whether kernels make what follows from all faces: a GPU has made the topology, and the frusta are there alone.
    /// Then faces()->part is set.
    bool is_on_device_alone() const;

    /// The boxes of all clusters, and what else an index needs.
    ClusterIndex make_index();

    /// The floor of the sign rule `below`. Throws Error(invalid_argument) if it is not below the box, as moves do.
    void set_floor(double floor) {
        check_floor(floor, box_, name_);
        floor_ = floor;
    }

    // Moves. They leave the frusta to be made again.

    /// New positions of the vertices of on_host(). Throws Error(invalid_mesh) if one in use is not finite.
    void move(std::vector<Vec3> positions);
    /// The same in a box that is known: that of the whole mesh, of which this is a part. The positions are finite.
    void move(std::vector<Vec3> positions, const Box& box);
    /// The frusta at the present positions, if they are found elsewhere.
    void set_frusta(Frusta frusta);
    /// New positions of the caller's vertices: DeviceTriples, or a span. The device gets them, and the host when it
    /// needs them. Returns false, and has done nothing, if the host has to look at them.
    template <class Positions>
    bool move_on_device(const Positions& positions, std::size_t count);
    /// Whether vertices count as one, and a GPU knows which.
    bool has_equal_on_device() const;

    /// Reads values that the device alone has and that could not be made again. Waits. Throws Error.
    void read_only_copies();
    /// Lets the faces leave the device if what they hold has left it.
    void leave_device_together();

    /// Bytes of the first positions, if there are others.
    std::size_t first_position_bytes() const;

private:
    /// On the host, as the caller gave it but for equal vertices.
    struct FirstMesh {
        std::shared_ptr<const Mesh> mesh;
        Vertices vertices;
        std::vector<std::uint32_t> numbers{};  ///< in `mesh`, of the caller's vertices; empty if they are the same
    };

    HomedMesh(KeptValues& all, const DeviceTools& tools, std::string name, const Box& box, std::size_t vertex_count,
              std::size_t face_count);

    const FirstMesh& first();
    void require_frusta() {
        if (!frusta_.is_made()) make_frusta(nullptr);
    }
    /// The vertices at new positions, on the device. Nothing if the host has to look at them.
    template <class Positions>
    std::optional<MovedVertices> moved_on_device(const Positions& positions);

    DeviceSetUp set_up_;
    std::string name_;
    Box first_box_, box_;
    std::optional<double> floor_;  // of the sign rule `below`
    std::size_t vertex_count_;     // of the caller's
    std::size_t face_count_;
    bool has_equal_ = false;  // vertices that count as one
    bool has_moved_ = false;
    std::shared_ptr<const BorrowedMesh> borrowed_;  // null if all is its own
    Homed<Mesh, DeviceMesh> given_;
    Kept<FirstMesh> first_;
    Kept<NamedFaces> names_;
    HomedTopology topology_;
    Homed<Mesh, device::BufferPool::Lease> positions_;
    HomedFrusta frusta_;
    Kept<FrustaSources> frusta_sources_;  // of processors; from the first move on
};

}  // namespace clsdf::engine

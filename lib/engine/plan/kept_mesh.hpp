#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "finish/finishing.hpp"
#include "frusta/cluster_index.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/device_topology.hpp"
#include "frusta/frusta.hpp"
#include "frusta/kernel_frusta.hpp"
#include "frusta/prepared_mesh.hpp"
#include "frusta/topology.hpp"
#include "launch/programs.hpp"
#include "mesh/open_edges.hpp"
#include "mesh/sign_surface.hpp"
#include "mesh/vertices.hpp"
#include "plan/job.hpp"
#include "plan/kept.hpp"
#include "plan/lattice.hpp"
#include "plan/restriction.hpp"
#include "sign/sweep_mesh.hpp"

#include <list>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <vector>

namespace clsdf {
class FieldMethod;
}

namespace clsdf::engine {

/// The values that a transform keeps of its mesh. Each is made from those above it when it is needed first, and again
/// only if one of them has changed.
///
///     Mesh           the caller's                        kept; from memory of a GPU, read when the host needs it.
///                                                        Vertices of equal coordinates count as one: it has one of
///                                                        each, from when the host needs it
///     MeshTopology   of the triangles                    kept; if a GPU has made it, read back when the host needs it
///     DeviceTopology the same on a GPU                   kept
///     Frusta, index  + positions                         kept until the vertices move
///     device's faces + positions                         the same
///     sites' names   of the triangles                    kept, once an output names sites
///     pseudonormals  + positions                         kept until the vertices move, once gradients need them
///     records        + lattice (origin and spacing)      kept for the lattices that were used last: see grid_inputs()
///
/// For one thread at a time.
class KeptMesh {
public:
    struct Options {
        Programs programs;
        std::shared_ptr<const FieldMethod> method{};  ///< null for leaned polyhedra scanned by bricks
        std::optional<std::size_t> kept_bytes{};      ///< see TransformOptions
        bool is_whole = false;                        ///< small grids, too, get records of the whole mesh
    };

    /// vertices: the caller's, as the mesh has them.
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh, Vertices vertices,
             Options options);
    /// All of the mesh's vertices are the caller's.
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, const Mesh& mesh, Options options)
        : KeptMesh(context, std::move(pool), mesh, Vertices(mesh.vertices().size()), std::move(options)) {}
    /// A mesh as given whose topology a GPU has made. It lacks its arrays if made.mesh has them.
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh, MadeTopology made,
             Options options);

    KeptMesh(const KeptMesh&) = delete;
    KeptMesh& operator=(const KeptMesh&) = delete;

    /// A mesh of only what samples and points of a box can need; see DistanceTransform::restrict_to().
    std::unique_ptr<KeptMesh> restricted(std::shared_ptr<device::BufferPool> pool, std::vector<Region> regions,
                                         SignRule sign);
    /// Null for the whole mesh.
    const Restriction* restriction() const { return restriction_.get().get(); }
    /// The job of what is asked for. Throws if a restricted mesh does not suffice for the field, or if the grid has
    /// more samples than kernels can number or lies too far from the mesh; see Restriction::check(), layout_of() and
    /// check_distance().
    Job checked(JobKey asked, SignRule sign) const;

    device::Context& context() const { return context_; }
    DeviceTools tools() const { return {context_, pool_, options_.programs}; }
    /// With its present positions, and one of each vertex.
    const Mesh& mesh();
    /// The caller's vertices as mesh() has them.
    const Vertices& vertices() {
        read_mesh();
        return vertices_;
    }
    /// The positions that it was made with.
    const std::vector<Vec3>& first_positions();
    const std::string& name() const { return mesh_.name(); }
    const Box& box() const { return mesh_.box(); }
    const MeshTopology& topology() { return *shared_topology(); }
    std::shared_ptr<const MeshTopology> shared_topology();
    const Frusta& frusta();
    /// The same, but their positions and slopes may be on the device alone.
    const Frusta& counted_frusta();
    std::size_t face_count() const { return face_count_; }

    /// The surface that decides the sign; that of the first positions serves all later ones. Without it the mesh
    /// decides.
    const SignSurface& sign_surface() const { return *sign_surface_; }
    void set_sign_surface(SignSurface surface) {
        sign_surface_.set(std::make_shared<const SignSurface>(std::move(surface)));
    }
    /// How far it may lie from the mesh, in the mesh's units, and more.
    double sign_surface_gap() const {
        return sign_surface().vertices.empty() ? 0 : 2 * joined_extent * mesh_.box().longest_side();
    }

    /// The open edges of that surface count, for the rule solid_angle.
    void set_open_loops(OpenLoops loops) { open_loops_.set(std::make_shared<const OpenLoops>(std::move(loops))); }
    /// At the present positions, of the whole mesh, also for a part of it; null if there are none that count.
    std::shared_ptr<const OpenBoundary> boundary();
    /// The same of a whole mesh, also if they do not count for the sign; may be empty.
    std::shared_ptr<const OpenBoundary> any_boundary();

    /// New positions of the mesh's vertices. Throws Error(invalid_mesh) if one in use is not finite.
    void move(std::vector<Vec3> positions);
    /// New positions of the caller's vertices, which the host gets when it needs them. Returns false, and has done
    /// nothing, if the host has to look at them.
    bool move(const DeviceTriples& positions) { return move_given(positions, positions.count); }
    /// The same, if some vertices count as one; others had better be moved by the function above, which needs no copy
    /// when the host needs the positions.
    bool move_equal(std::span<const Vec3> positions) {
        return equal_vertices_ && move_given(positions, positions.size());
    }

    bool encloses_negative_volume();

    /// The sites that finishing reads: their names for outputs that tell them (names_sites()), their pseudonormals for
    /// gradients on edges and vertices. Throws Error(out_of_memory).
    std::shared_ptr<const DeviceSites> sites(bool with_names, bool with_normals);

    // Of a lattice.

    /// The kept values of a grid's lattice, which becomes the one that was used last.
    Lattice& lattice(const Grid& grid);
    /// Whether gradients on the lattice need pseudonormals: samples may lie on an edge or a vertex, or on a face that
    /// is turned around for the sign.
    bool needs_normals(Lattice& lattice);
    /// The records that a lattice keeps: all; for a part of a mesh, those that distances in its box can need. Faces
    /// that a part has for the sign alone need no records.
    const NearRecords& kept_ranges(Lattice& lattice);
    /// Records of the whole mesh, or of some ranges, which are not kept. Throws Error(out_of_memory).
    PreparedMesh all_records(const LatticeView& view);
    PreparedMesh records(const LatticeView& view, const NearRecords& ranges);
    SurfacePoints points_of(const LatticeView& view);
    /// The mesh of the sign, which is not kept. Throws Error(out_of_memory or unsupported).
    SweepMesh sweep_mesh(const Job& job);
    /// The same of the faces near a grid alone.
    SweepMesh near_sweep_mesh(const Job& job, const NearRecords& near);
    /// The clusters of faces, for what is near a box.
    const ClusterIndex& index();
    /// Whether the frusta are made, of which index() is made.
    bool has_frusta() const { return static_cast<bool>(frusta_); }
    /// Whether the kernels can make lists of a part of the records.
    bool has_selections() const { return options_.programs.body == KernelBody::by_vector; }

    const Options& options() const { return options_; }

    /// The values that it keeps, without those of lattices. Others may add values, and must live as long as calls are
    /// made.
    KeptValues& kept() { return kept_; }

    /// Returns what make() returns. Throws Error(out_of_memory) if the host has too little memory.
    template <typename Make>
    auto prepare(const Make& make) const {
        try {
            return make();
        } catch (const std::bad_alloc&) {
            refuse_memory();
        }
    }

    /// Limit of the device memory that is kept, in bytes.
    std::size_t budget();
    /// Forgets what does not fit in the budget, in bytes of the device's memory.
    void keep_within(std::size_t budget);
    /// Forgets everything on the device that no plan holds.
    void release();

    /// All memory that is kept.
    KeptMemory memory();
    std::size_t device_bytes() { return memory().device_bytes; }
    /// Whether a lattice keeps these records, or this mesh of the sign.
    bool keeps(const std::shared_ptr<const PreparedMesh>& records) const;
    bool keeps(const std::shared_ptr<const SweepMesh>& sweep_mesh) const;
    /// Bytes of the records that a lattice keeps.
    std::size_t record_bytes() const;

private:
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, MeshPart part, Restriction restriction,
             Options options);

    /// With those of lattices: the mesh's own values come first, then the lattices, the last used first.
    KeptValues all_kept();
    /// Forgets these, the last first: before the values that they are made of, whose memory they may share.
    void forget_if(bool (*condition)(const KeptValue&));
    [[noreturn]] void refuse_memory() const;
    /// The vertices at new positions, on the device; the values of the ones before are forgotten. Nothing, and has done
    /// nothing, if the host has to look at the positions. They have the numbers of device_topology_. equal: see
    /// move_vertices().
    template <class Positions>
    std::optional<MovedVertices> moved_on_device(const Positions& positions, const EqualVertices* equal);
    void forget_positions();
    /// Before the first move.
    void keep_first_positions();
    /// Makes the mesh complete: from device_mesh_, which is given up, and without vertices that equal others.
    void read_mesh();
    template <class Positions>
    bool move_given(const Positions& positions, std::size_t count);

    DeviceSetUp set_up() const { return {tools()}; }
    const std::shared_ptr<const DeviceFaces::Names>& names();
    /// Makes the frusta, and their records for a lattice if it is not null and kernels make them.
    std::optional<PreparedMesh> make_frusta(const LatticeView* lattice);
    /// The faces that the host writes records of.
    WrittenFaces written_faces(const DeviceFaces& faces);
    /// Null if the host makes the lattice's records, and the vertices of its sweep.
    std::shared_ptr<const DeviceFaces> device_faces(const LatticeView& lattice);
    /// Whether a GPU has made the topology, and has the frusta by itself.
    bool has_faces_of_gpu() const;
    /// Whether kernels make all of the job's sweep mesh. faces: null if there are none.
    bool is_swept_on_device(const Job& job, const DeviceFaces* faces) const;
    /// The records of the whole mesh.
    NearRecords all_ranges();

    device::Context& context_;
    std::shared_ptr<device::BufferPool> pool_;
    Options options_;
    Mesh mesh_;
    Vertices vertices_;
    std::size_t face_count_;
    bool is_as_given_ = false;           // vertices that equal others are not merged yet
    std::vector<Vec3> first_positions_;  // from the first move on, once the mesh is complete
    bool has_moved_ = false;
    bool is_moving_ = false;          ///< the values of the positions before are given up
    bool has_old_positions_ = false;  ///< the mesh; the present ones are on the device alone
    KeptValues kept_;                 // those that follow, in their order
    // The first positions and the triangles as given, which mesh_ lacks.
    Kept<DeviceMesh> device_mesh_{kept_, MadeOf::triangles, UsedBy::both, [this] { read_mesh(); }};
    Kept<EqualVertices> equal_vertices_{kept_, MadeOf::triangles, UsedBy::both, [this] { read_mesh(); }};
    Kept<Restriction> restriction_{kept_, MadeOf::triangles};
    Kept<SignSurface> sign_surface_{kept_, MadeOf::triangles};
    Kept<OpenLoops> open_loops_{kept_, MadeOf::triangles};
    Kept<OpenBoundary> boundary_{kept_, MadeOf::positions};  // any_boundary(), if none count
    Kept<MeshTopology> topology_{kept_, MadeOf::triangles};
    std::vector<std::uint32_t> numbers_;  // in mesh_, of the caller's vertices; empty if they are the same
    Kept<bool> encloses_negative_volume_{kept_, MadeOf::positions};
    Kept<Frusta> frusta_{kept_, MadeOf::positions, UsedBy::grids, [this] { partial_frusta_.reset(); }};
    std::shared_ptr<Frusta> partial_frusta_;  // those, as long as their positions and slopes are on the device alone
    Kept<ClusterIndex> index_{kept_, MadeOf::positions};  // a grid around the whole mesh needs none
    Kept<device::BufferPool::Lease> site_names_{kept_, MadeOf::triangles, UsedBy::both};
    Kept<device::BufferPool::Lease> pseudonormals_{kept_, MadeOf::positions, UsedBy::both};
    Kept<DeviceFaces::Names> names_{kept_, MadeOf::triangles, UsedBy::grids, [this] { faces_.forget(); }};
    // Of GPUs: as the topology numbers the vertices. The mesh may lack them, and the faces use them.
    Kept<device::BufferPool::Lease> positions_{kept_, MadeOf::positions, UsedBy::grids, [this] {
                                                   if (!is_moving_) mesh();
                                                   faces_.forget();
                                               }};
    // Which hold their names, and what partial frusta lack.
    Kept<DeviceFaces> faces_{kept_, MadeOf::positions, UsedBy::grids, [this] {
                                 if (partial_frusta_) frusta_.forget();
                             }};
    Kept<FrustaSources> frusta_sources_{kept_, MadeOf::triangles};  // from the first move on; of processors
    // Of GPUs; its order is that of the first positions.
    Kept<DeviceTopology> device_topology_{kept_, MadeOf::triangles, UsedBy::grids, [this] {
                                              if (has_moved_) topology();
                                          }};
    std::list<Lattice> lattices_;  // that was used last first
};

}  // namespace clsdf::engine

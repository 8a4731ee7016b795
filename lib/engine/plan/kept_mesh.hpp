#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "finish/finishing.hpp"
#include "finish/given_faces.hpp"
#include "frusta/cluster_index.hpp"
#include "frusta/homed_mesh.hpp"
#include "frusta/prepared_mesh.hpp"
#include "homes/kept.hpp"
#include "launch/programs.hpp"
#include "plan/job.hpp"
#include "plan/joined_meshes.hpp"
#include "plan/lattice.hpp"
#include "plan/part_mover.hpp"
#include "plan/region_part.hpp"
#include "sign/exact_sides.hpp"
#include "sign/sweep_mesh.hpp"
#include "surface/open_edges.hpp"
#include "surface/sign_surface.hpp"

#include <atomic>
#include <cstddef>
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

/// KeptMesh::sites(), in borrowed memory.
struct BorrowedSites {
    device::BufferPool::Lease names, normals;
};

/// The values that a transform keeps of its mesh for grids: lattices and their records, within a budget of the device's
/// memory. Each is made from those above it when it is needed first, and again only if one of them has changed.
///
///     HomedMesh      topology, positions, frusta         kept on the host, on the device or on both
///     index          + frusta                            kept until the vertices move
///     sites' names   of the triangles                    kept, once an output names sites
///     pseudonormals  + positions                         kept until the vertices move, once gradients need them
///     records        + lattice (origin and spacing)      kept for the lattices that were used last: see grid_inputs()
///
/// For one thread at a time, but moves(), and name() and box() between moves.
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
    /// All of the mesh's vertices are the caller's, and the host has made the topology.
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh,
             std::shared_ptr<const MeshTopology> topology, Options options);
    /// A mesh as given whose topology a GPU has made; null if made.mesh has the arrays.
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, std::shared_ptr<const Mesh> given,
             MadeTopology made, Options options);

    /// A whole mesh whose large arrays are borrowed. sites: of it; without leases if they are made when they are
    /// needed.
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, BorrowedMesh mesh, BorrowedSites sites,
             Options options);

    KeptMesh(const KeptMesh&) = delete;
    KeptMesh& operator=(const KeptMesh&) = delete;

    /// A mesh of only what samples and points of regions can need; see DistanceTransform::restrict_to().
    KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, RegionPart part, Options options);
    /// The part of which such a mesh of this one is made. margin: by which its vertices may move; 0 if they stay.
    /// Throws Error(unsupported) for a margin that the mesh cannot have.
    RegionPart part_of_regions(std::vector<Region> regions, SignRule sign, double margin);
    /// The part of which this mesh was made, if it is one.
    RegionPart own_part();
    /// Null for the whole mesh.
    const Restriction* restriction() const { return restriction_.get().get(); }
    /// Null for the whole mesh, and for a part whose vertices stay.
    const MovablePart* movable() const { return mover_ ? mover_->movable().get() : nullptr; }
    /// Fields are those of some of the joined meshes, whose numbers ascend: see records_of_meshes().
    void select_meshes(std::vector<std::uint32_t> meshes) { selected_ = std::move(meshes); }
    bool has_selection() const { return !selected_.empty(); }
    NearRecords selected() { return records_of_meshes(topology(), mesh_.found(), selected_); }
    /// The triangles are pieces of faces, or faces of other meshes, and are told by these.
    void set_given_faces(GivenFaces faces) { given_faces_.set(std::make_shared<const GivenFaces>(std::move(faces))); }
    /// Whether the triangles' own numbers are those that are told.
    bool has_own_numbers() const { return !given_faces_ && !restriction_; }
    /// By triangle: the number that is told; empty if it is its own.
    std::span<const std::uint32_t> numbers() const {
        if (given_faces_) return given_faces_->numbers;
        return restriction_ ? std::span<const std::uint32_t>(restriction_->numbers) : std::span<const std::uint32_t>();
    }
    /// The job of what is asked for. Throws if a restricted mesh does not suffice for the field, or if the grid has
    /// more samples than kernels can number or lies too far from the mesh; see Restriction::check(), layout_of() and
    /// check_distance().
    Job checked(JobKey asked, SignRule sign) const;

    device::Context& context() const { return context_; }
    DeviceTools tools() const { return {context_, pool_, options_.programs}; }
    /// With its present positions, and one of each vertex.
    const Mesh& mesh() { return mesh_.on_host(); }
    /// The caller's vertices as mesh() has them.
    const Vertices& vertices() { return mesh_.vertices(); }
    /// Of mesh(), without making it of borrowed arrays.
    PlacedVertices present() { return mesh_.present(); }
    std::span<const Triangle> triangles() { return mesh_.triangles(); }
    bool has_moved() const { return mesh_.has_moved(); }
    const std::shared_ptr<const NamedFaces>& names() { return mesh_.names(); }
    /// Null unless open edges count.
    const OpenLoops* open_loops() const { return open_loops_.get().get(); }
    /// The positions that it was made with.
    const std::vector<Vec3>& first_positions() { return mesh_.first_positions(); }
    const std::string& name() const { return mesh_.name(); }
    const Box& box() const { return mesh_.box(); }
    const MeshTopology& topology() { return mesh_.topology(); }
    const std::shared_ptr<const MeshTopology>& shared_topology() { return mesh_.shared_topology(); }
    /// The faces on the device if they are there already; else null.
    const std::shared_ptr<const NamedFaces>& made_names() const { return mesh_.made_names(); }
    /// The mesh on the device if kernels have made its topology, and if its faces alone decide the sign; else null.
    std::shared_ptr<const DeviceTopology> topology_on_device() const;
    const std::shared_ptr<const device::BufferPool::Lease>& positions_on_device() {
        return mesh_.positions_on_device();
    }
    const Frusta& frusta() { return mesh_.frusta(); }
    std::size_t face_count() const { return mesh_.face_count(); }
    const SetUpWays& ways() const { return mesh_.set_up().ways; }

    /// The surface that decides the sign; that of the first positions serves all later ones. Without it the mesh
    /// decides.
    const SignSurface& sign_surface() const { return *sign_surface_; }
    void set_sign_surface(SignSurface surface) {
        sign_surface_.set(std::make_shared<const SignSurface>(std::move(surface)));
    }
    /// How far it may lie from the mesh, in the mesh's units, and more.
    double sign_surface_gap() const {
        return sign_surface().vertices.empty() ? 0 : 2 * joined_extent * box().longest_side();
    }

    /// The open edges of that surface count, for the rules solid_angle and below. Throws Error(invalid_argument) if
    /// their floor is not below the mesh.
    void set_open_loops(OpenLoops loops) {
        if (loops.floor) mesh_.set_floor(*loops.floor);
        open_loops_.set(std::make_shared<const OpenLoops>(std::move(loops)));
    }
    /// At the present positions, of the whole mesh, also for a part of it; null if there are none that count.
    std::shared_ptr<const OpenBoundary> boundary();
    /// The same of a whole mesh, also if they do not count for the sign; may be empty.
    std::shared_ptr<const OpenBoundary> any_boundary();

    /// New positions of the mesh's vertices. Throws Error(invalid_mesh) if one in use is not finite.
    void move(std::vector<Vec3> positions);
    /// New positions of the caller's vertices, which the host gets when it needs them. Returns false, and has done
    /// nothing, if the host has to look at them.
    bool move(const DeviceTriples& positions) { return move_on_device(positions, positions.count); }
    /// The same, if vertices count as one; others had better be moved by the function above, which needs no copy when
    /// the host needs the positions.
    bool move_equal(std::span<const Vec3> positions) {
        return mesh_.has_equal_on_device() && move_on_device(positions, positions.size());
    }

    /// The same of the vertices of such a part: see PartMover::moved().
    void move_part(std::span<const Vec3> positions);

    /// How often the vertices have moved. For any number of threads.
    std::size_t moves() const { return moves_; }

    /// Throws Error(unsupported) if a part that has moved cannot tell.
    bool encloses_negative_volume();
    /// At the present positions, for those who know it.
    void set_encloses_negative_volume(bool value) {
        encloses_negative_volume_.set(std::make_shared<const bool>(value));
    }

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
    /// The mesh as kernels cross it exactly; null if the host does: on a processor by its own body, of a part of a
    /// mesh, and if another surface than the mesh decides the sign, or its open edges count. Throws
    /// Error(invalid_argument or out_of_memory).
    std::optional<CrossedMesh> crossed_mesh();
    /// The clusters of faces, for what is near a box.
    const ClusterIndex& index();
    /// Whether the frusta are made, of which index() is made.
    bool has_frusta() const { return mesh_.has_frusta(); }

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
    /// Gives up what does not fit in the budget, in bytes of the device's memory, and could be made again.
    void keep_within(std::size_t budget);
    /// Gives up everything on the device that no plan holds and that could be made again.
    void release();
    /// Reads the rest to the host, so that release() gives it up, too. Throws Error.
    void read_only_copies() { mesh_.read_only_copies(); }
    /// The same if the budget has no room for it.
    void keep_only_copies_within_budget();

    /// All memory that is kept.
    KeptMemory memory();
    std::size_t device_bytes() { return memory().device_bytes; }
    /// Whether a lattice keeps these records, or this mesh of the sign.
    bool keeps(const std::shared_ptr<const PreparedMesh>& records) const;
    bool keeps(const std::shared_ptr<const SweepMesh>& sweep_mesh) const;
    /// Bytes of the records that a lattice keeps.
    std::size_t record_bytes() const;

private:
    /// The mesh's own values come first, then the lattices, the last used first.
    template <class Visit>
    void each_kept(const Visit& visit);
    /// Bytes of what only the device has and could not be made again.
    std::size_t only_copy_bytes() const;
    /// Gives up what was made of other positions.
    void forget_positions();
    /// Of the whole mesh, of which this is a part.
    void set_volume_of_whole(const std::optional<bool>& is_negative);
    template <class Positions>
    bool move_on_device(const Positions& positions, std::size_t count);
    [[noreturn]] void refuse_memory() const;

    /// Null if the host makes the lattice's records, and the vertices of its sweep.
    std::shared_ptr<const DeviceFaces> device_faces(const LatticeView& lattice);
    /// Whether kernels make all of the job's sweep mesh. faces: null if there are none.
    bool is_swept_on_device(const Job& job, const DeviceFaces* faces) const;
    /// The records of the whole mesh.
    NearRecords all_ranges();

    device::Context& context_;
    std::shared_ptr<device::BufferPool> pool_;
    Options options_;
    KeptValues kept_;  // those that follow, in their order
    HomedMesh mesh_;
    std::unique_ptr<PartMover> mover_;
    bool volume_is_unknown_ = false;
    Kept<Restriction> restriction_{kept_, MadeOf::triangles};
    Kept<GivenFaces> given_faces_{kept_, MadeOf::triangles};
    Kept<SignSurface> sign_surface_{kept_, MadeOf::triangles};
    Kept<OpenLoops> open_loops_{kept_, MadeOf::triangles};
    Kept<OpenBoundary> boundary_{kept_, MadeOf::positions};  // any_boundary(), if none count
    Kept<bool> encloses_negative_volume_{kept_, MadeOf::positions};
    Kept<ClusterIndex> index_{kept_, MadeOf::positions};  // a grid around the whole mesh needs none
    Kept<device::BufferPool::Lease> site_names_{kept_, MadeOf::triangles, UsedBy::both};
    Kept<device::BufferPool::Lease> pseudonormals_{kept_, MadeOf::positions, UsedBy::both};
    std::list<Lattice> lattices_;  // that was used last first
    std::vector<std::uint32_t> selected_;
    std::atomic<std::size_t> moves_ = 0;
};

}  // namespace clsdf::engine

#include "plan/kept_mesh.hpp"

#include "device/read_back.hpp"
#include "finish/sites.hpp"
#include "frusta/host_part.hpp"
#include "lattice/layout_of.hpp"
#include "mesh/box_index.hpp"
#include "mesh/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clsdf::engine {

namespace {

/// Throws Error(invalid_argument) if no end of the band keeps distances within the range of a float.
void check_unbounded_distances(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign) {
    if (std::isfinite(sign == SignRule::none ? band.outside : band.widest())) return;
    Box all = grid.box();
    add(all, mesh.box());
    const double diagonal =
        std::hypot(all.upper[0] - all.lower[0], all.upper[1] - all.lower[1], all.upper[2] - all.lower[2]);
    if (diagonal > static_cast<double>(std::numeric_limits<float>::max()))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid and mesh have a diagonal of {}, beyond the floats that distances are given in; "
                                "scale the mesh, or give the band an end",
                                diagonal));
}

}  // namespace

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh, Vertices vertices,
                   Options options)
    : context_(context),
      pool_(std::move(pool)),
      options_(std::move(options)),
      mesh_(std::move(mesh)),
      vertices_(std::move(vertices)),
      face_count_(mesh_.triangles().size()) {
    set_sign_surface({});
}

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh, MadeTopology made,
                   Options options)
    : KeptMesh(context, std::move(pool), std::move(mesh), Vertices(made.given_vertices), std::move(options)) {
    face_count_ = made.topology->face_count();
    is_as_given_ = made.equal != nullptr;
    // Of other meshes another surface may decide the sign.
    if (made.topology->are_paired)
        encloses_negative_volume_.set(std::make_shared<const bool>(made.encloses_negative_volume()));
    device_mesh_.set(std::move(made.mesh));
    equal_vertices_.set(std::move(made.equal));
    positions_.set(std::make_shared<const device::BufferPool::Lease>(std::move(made.positions)));
    names_.set(made.topology->names);
    device_topology_.set(std::move(made.topology));
}

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, MeshPart part,
                   Restriction restriction, Options options)
    : KeptMesh(context, std::move(pool), std::move(part.mesh), Vertices(), std::move(options)) {
    restriction_.set(std::make_shared<const Restriction>(std::move(restriction)));
    set_sign_surface(std::move(part.surface));
    topology_.set(std::move(part.topology));
    frusta_.set(std::make_shared<const Frusta>(std::move(part.frusta)));
}

std::unique_ptr<KeptMesh> KeptMesh::restricted(std::shared_ptr<device::BufferPool> pool, std::vector<Region> regions,
                                               SignRule sign) {
    return prepare([&] {
        Restriction restriction(std::move(regions));
        MeshPart part =
            part_of(mesh(), sign_surface(), topology(), frusta(), restriction.near(index(), sign, sign_surface_gap()));
        restriction.numbers = std::move(part.triangles);
        restriction.sample = surface_sample(topology(), frusta());
        std::unique_ptr<KeptMesh> kept_mesh(
            new KeptMesh(context_, std::move(pool), std::move(part), std::move(restriction), options_));
        kept_mesh->encloses_negative_volume_.set(std::make_shared<const bool>(encloses_negative_volume()));
        if (boundary() != nullptr) {
            kept_mesh->open_loops_.set(open_loops_.get());
            kept_mesh->boundary_.set(boundary_.get());
        }
        return kept_mesh;
    });
}

Job KeptMesh::checked(JobKey asked, SignRule sign) const {
    if (restriction_) restriction_->check(asked.grid, asked.band, sign);
    Job job{std::move(asked)};
    job.lattice = lattice_of(job.grid);
    check_distance(mesh_, job.lattice);
    job.layout = layout_of(job.grid, job.band, sign);
    check_unbounded_distances(mesh_, job.grid, job.band, sign);
    return job;
}

void KeptMesh::read_mesh() {
    if (!device_mesh_ && !is_as_given_) return;
    context_.begin_call();
    // Other threads may read the mesh's name and its box, which stay.
    if (device_mesh_) {
        set_arrays(mesh_, device_mesh_->read(set_up()));
        device_mesh_.set(nullptr);
    }
    if (is_as_given_) {
        const std::vector<std::uint32_t> first = equal_vertices_->read(set_up());
        Mesh one_of_each = mesh_;
        vertices_ = Vertices(one_of_each, first);
        numbers_ = Vertices::numbers(first);
        set_arrays(mesh_, {one_of_each.vertices(), one_of_each.triangles()});
        is_as_given_ = false;
    }
    if (has_moved_) first_positions_ = mesh_.vertices();
}

void KeptMesh::keep_first_positions() {
    if (!has_moved_ && !device_mesh_ && !is_as_given_) first_positions_ = mesh_.vertices();
}

const std::vector<Vec3>& KeptMesh::first_positions() {
    read_mesh();
    return has_moved_ ? first_positions_ : mesh_.vertices();
}

const Mesh& KeptMesh::mesh() {
    read_mesh();
    if (!has_old_positions_) return mesh_;
    context_.begin_call();
    UninitializedVector<Vec3> ordered(topology().faces.vertices.size());
    context_.run_or_drain([&] { device::read_values(context_, **positions_, ordered); });
    set_ordered_positions(mesh_, topology(), ordered);
    has_old_positions_ = false;
    return mesh_;
}

void KeptMesh::move(std::vector<Vec3> positions) {
    read_mesh();  // now: a later read would replace the new positions
    keep_first_positions();
    // A topology that a GPU has made has the caller's numbers.
    if (numbers_.empty() && positions.size() == mesh_.vertices().size())
        if (const auto moved = moved_on_device(std::span<const Vec3>(positions), nullptr)) {
            engine::move(mesh_, moved->box, std::move(positions));
            has_old_positions_ = false;
            return;
        }
    topology();                                             // of the first positions
    engine::move(mesh_, *topology_, std::move(positions));  // which finds what is wrong
    forget_positions();
}

template <class Positions>
bool KeptMesh::move_given(const Positions& positions, std::size_t count) {
    const bool knows_equal = equal_vertices_ || (!is_as_given_ && !vertices_.are_merged());
    if (!sign_surface().vertices.empty() || !knows_equal || count != vertices_.count()) return false;
    keep_first_positions();
    const auto moved = moved_on_device(positions, equal_vertices_.get().get());
    if (!moved) return false;
    engine::move(mesh_, moved->box);
    has_old_positions_ = true;
    return true;
}
template bool KeptMesh::move_given(const DeviceTriples&, std::size_t);
template bool KeptMesh::move_given(const std::span<const Vec3>&, std::size_t);

template <class Positions>
std::optional<MovedVertices> KeptMesh::moved_on_device(const Positions& positions, const EqualVertices* equal) {
    if (!device_topology_) return std::nullopt;
    context_.begin_call();
    MovedVertices moved;
    try {
        moved = move_vertices(set_up(), *device_topology_, equal, positions);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::out_of_memory) throw;
        return std::nullopt;
    }
    if (!moved.are_usable) return std::nullopt;
    auto kept = std::make_shared<const device::BufferPool::Lease>(std::move(moved.positions));
    forget_positions();
    positions_.set(std::move(kept));
    return moved;
}

void KeptMesh::forget_positions() {
    is_moving_ = true;
    has_moved_ = true;
    has_old_positions_ = false;
    forget_if([](const KeptValue& value) { return value.made_of == MadeOf::positions; });
    is_moving_ = false;
}

void KeptMesh::refuse_memory() const {
    throw Error(ErrorCode::out_of_memory,
                fmt::format("preparing {}, {} triangles, takes more than the host's memory; divide the mesh",
                            mesh_.name(), face_count_));
}

std::shared_ptr<const MeshTopology> KeptMesh::shared_topology() {
    return topology_.get_or([&] {
        if (is_as_given_ || !device_topology_) read_mesh();  // which finds numbers_
        if (device_topology_) return device_topology_->read(set_up(), numbers_);
        return MeshTopology(mesh_);
    });
}

const Frusta& KeptMesh::counted_frusta() {
    if (!frusta_) make_frusta(nullptr);
    return *frusta_;
}

const Frusta& KeptMesh::frusta() {
    counted_frusta();
    if (partial_frusta_) {
        fill(set_up(), *faces_, *partial_frusta_);
        partial_frusta_.reset();
    }
    return *frusta_;
}

const std::shared_ptr<const DeviceFaces::Names>& KeptMesh::names() {
    return names_.get_or([&] { return device_names(set_up(), shared_topology()); });
}

std::optional<PreparedMesh> KeptMesh::make_frusta(const LatticeView* lattice) {
    if (!suits_kernels(face_count())) {
        frusta_.get_or([&] { return engine::make_frusta(topology(), mesh().vertices()); });
        return std::nullopt;
    }
    const DeviceSetUp job = set_up();
    MadeFrusta made = [&] {
        if (job.shares_memory()) {
            frusta_sources_.get_or([&] { return FrustaSources(job, topology()); });
            return frusta_by_kernels(job, names(), frusta_sources_.get(), mesh(), lattice);
        }
        device_topology_.get_or([&] {
            equal_vertices_.forget();  // from now on it has the mesh's numbers of vertices, not the caller's
            return device_topology(job, names(), topology());
        });
        positions_.get_or([&] { return job.upload(ordered_positions(topology(), mesh().vertices()), "vertices"); });
        return frusta_by_kernels(
            job, *device_topology_, {nullptr, **positions_, 0}, mesh_.box(),
            [this]() -> const MeshTopology& { return topology(); }, lattice);
    }();
    partial_frusta_ = made.faces.part ? made.frusta : nullptr;
    frusta_.set(std::move(made.frusta));
    faces_.set(std::make_shared<const DeviceFaces>(std::move(made.faces)));
    if (!has_moved_) frusta_sources_.forget();
    return std::move(made.records);
}

const ClusterIndex& KeptMesh::index() {
    return *index_.get_or([&] {
        counted_frusta();
        if (has_faces_of_gpu())
            return ClusterIndex(face_count_, cluster_boxes(set_up(), *faces_), faces_->part->frusta);
        return ClusterIndex(face_count_, cluster_boxes(topology().faces.triangles, frusta().positions), frusta());
    });
}

std::shared_ptr<const DeviceFaces> KeptMesh::device_faces(const LatticeView& lattice) {
    if (options_.method || !suits_kernels(face_count()) || !is_plain(mesh_, lattice)) return nullptr;
    counted_frusta();
    return faces_.get_or([&] { return engine::device_faces(set_up(), names(), frusta_.get()); });
}

WrittenFaces KeptMesh::written_faces(const DeviceFaces& faces) {
    if (faces.part) return {faces.part->topology, faces.part->frusta, faces.part->faces};
    return {topology(), frusta()};
}

PreparedMesh KeptMesh::all_records(const LatticeView& lattice) {
    if (!frusta_ && is_plain(mesh_, lattice))
        if (std::optional<PreparedMesh> first = make_frusta(&lattice)) return std::move(*first);
    return records(lattice, all_ranges());
}

PreparedMesh KeptMesh::records(const LatticeView& lattice, const NearRecords& ranges) {
    if (const auto faces = device_faces(lattice))
        return records_on_device(set_up(), *faces, written_faces(*faces), *frusta_, lattice, ranges.faces,
                                 ranges.sites);
    return records_by_host(tools(), topology(), frusta(), lattice, ranges.faces, ranges.sites);
}

Lattice& KeptMesh::lattice(const Grid& grid) {
    const auto found = std::ranges::find_if(lattices_, [&](const Lattice& lattice) { return lattice.is_of(grid); });
    if (found != lattices_.end()) {
        lattices_.splice(lattices_.begin(), lattices_, found);
        return *found;
    }
    // A lattice without records is not in the budget, and a caller may use a new lattice in each call.
    constexpr std::size_t most_lattices = 64;
    if (lattices_.size() == most_lattices) lattices_.pop_back();
    return lattices_.emplace_front(grid.origin, grid.spacing);
}

NearRecords KeptMesh::all_ranges() {
    const std::size_t faces = face_count(), sites = counted_frusta().sites.size();
    return {{{0, faces}}, {{0, sites}}, faces, sites};
}

const NearRecords& KeptMesh::kept_ranges(Lattice& lattice) {
    std::optional<NearRecords>& ranges = lattice.record_ranges;
    if (!ranges)
        ranges = restriction_ ? restriction_->near_bricks(index(), lattice.origin, lattice.spacing) : all_ranges();
    return *ranges;
}

SurfacePoints KeptMesh::points_of(const LatticeView& view) {
    return surface_points(restriction_ ? restriction_->sample : surface_sample(topology(), frusta()), view);
}

bool KeptMesh::has_faces_of_gpu() const {
    return partial_frusta_ != nullptr && faces_->names->topology == nullptr;
}

bool KeptMesh::is_swept_on_device(const Job& job, const DeviceFaces* faces) const {
    return faces != nullptr && sign_surface().is_mesh() && is_within_sweep(mesh_.box(), job.grid, job.lattice);
}

SweepMesh KeptMesh::sweep_mesh(const Job& job) {
    const auto faces = device_faces(job.lattice);
    const Mesh& swept = is_swept_on_device(job, faces.get()) ? mesh_ : mesh();
    return make_sweep_mesh(
        set_up(), job.grid, job.lattice, swept, sign_surface(), boundary().get(), names(),
        [this]() -> const MeshTopology& { return topology(); }, faces.get());
}

SweepMesh KeptMesh::near_sweep_mesh(const Job& job, const NearRecords& near) {
    const auto faces = has_faces_of_gpu() && boundary() == nullptr ? device_faces(job.lattice) : nullptr;
    if (is_swept_on_device(job, faces.get()))
        return engine::near_sweep_mesh(set_up(), job.grid, job.lattice, mesh_.box(), *faces, near);
    return engine::near_sweep_mesh(tools(), job.grid, job.lattice, mesh(), sign_surface(), boundary().get(), topology(),
                                   near.faces);
}

bool KeptMesh::needs_normals(Lattice& lattice) {
    if (!sign_surface().faces.empty()) return true;
    if (!lattice.may_meet_samples)
        lattice.may_meet_samples =
            engine::may_meet_samples(topology(), frusta().positions, lattice.origin, lattice.spacing);
    return *lattice.may_meet_samples;
}

std::shared_ptr<const OpenBoundary> KeptMesh::boundary() {
    if (!open_loops_) return nullptr;
    return boundary_.get_or([&] { return OpenBoundary(*open_loops_, mesh().vertices()); });
}

std::shared_ptr<const OpenBoundary> KeptMesh::any_boundary() {
    if (open_loops_) return boundary();
    return boundary_.get_or([&] { return OpenBoundary(open_loops_of(mesh(), sign_surface()), mesh().vertices()); });
}

bool KeptMesh::encloses_negative_volume() {
    return *encloses_negative_volume_.get_or([&] { return clsdf::encloses_negative_volume(mesh(), sign_surface()); });
}

std::shared_ptr<const DeviceSites> KeptMesh::sites(bool with_names, bool with_normals) {
    return prepare([&] {
        std::span<const std::uint32_t> numbers;
        if (restriction_) numbers = restriction_->numbers;
        if (with_names) site_names_.get_or([&] { return site_names(tools(), topology(), numbers); });
        if (with_normals)
            pseudonormals_.get_or([&] { return site_normals(tools(), mesh(), sign_surface(), topology()); });
        return std::make_shared<const DeviceSites>(DeviceSites{site_names_.get(), pseudonormals_.get(),
                                                               site_names_ ? numbers.size() : 0,
                                                               pseudonormals_ ? sign_surface().faces.size() : 0});
    });
}

KeptValues KeptMesh::all_kept() {
    KeptValues all = kept_;
    for (Lattice& lattice : lattices_) all.push_back(&lattice);
    return all;
}

void KeptMesh::forget_if(bool (*condition)(const KeptValue&)) {
    KeptValues all = all_kept();
    std::ranges::reverse(all);
    for (KeptValue* value : all)
        if (condition(*value)) value->forget();
}

std::size_t KeptMesh::budget() {
    std::size_t point_bytes = 0, shared_bytes = 0;
    for (const KeptValue* value : kept_) {
        if (value->used_by == UsedBy::points) point_bytes += value->memory().device_bytes;
        if (value->used_by == UsedBy::both) shared_bytes += value->memory().device_bytes;
    }
    if (point_bytes > 0) point_bytes += shared_bytes;
    return options_.kept_bytes.value_or(std::max(2 * record_bytes() + point_bytes, std::size_t{1} << 28));
}

void KeptMesh::keep_within(std::size_t budget) {
    for (KeptValue* value : all_kept()) {
        const std::size_t bytes = value->memory().device_bytes;
        if (bytes > budget)
            value->forget();
        else
            budget -= bytes;
    }
}

void KeptMesh::release() {
    // Views of the host's arrays have no bytes of the device, but hold the names.
    if (faces_.memory().device_bytes == 0 && !faces_.is_in_use()) faces_.forget();
    forget_if([](const KeptValue& value) { return value.memory().device_bytes > 0 && !value.is_in_use(); });
}

KeptMemory KeptMesh::memory() {
    KeptMemory sum;
    if (has_moved_) sum.host_bytes = first_positions_.size() * sizeof(Vec3);
    for (const KeptValue* value : all_kept()) {
        const KeptMemory memory = value->memory();
        sum.host_bytes += memory.host_bytes;
        sum.device_bytes += memory.device_bytes;
    }
    return sum;
}

bool KeptMesh::keeps(const std::shared_ptr<const PreparedMesh>& records) const {
    return std::ranges::find(lattices_, records, &Lattice::records) != lattices_.end();
}

bool KeptMesh::keeps(const std::shared_ptr<const SweepMesh>& sweep_mesh) const {
    return std::ranges::find(lattices_, sweep_mesh, &Lattice::sweep_mesh) != lattices_.end();
}

std::size_t KeptMesh::record_bytes() const {
    return (restriction_ ? restriction_->record_count : face_count_) * sizeof(Polyhedron);
}

}  // namespace clsdf::engine

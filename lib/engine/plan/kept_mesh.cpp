#include "plan/kept_mesh.hpp"

#include "core/refuse.hpp"
#include "finish/sites.hpp"
#include "lattice/layout_of.hpp"
#include "mesh/box_index.hpp"
#include "surface/topology.hpp"
#include "tree/point_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>
#include <utility>

namespace clsdf::engine {

namespace {

/// Throws Error(invalid_argument) if no end of the band keeps distances within the range of a float.
void check_unbounded_distances(const Box& mesh, const Grid& grid, const Band& band, SignRule sign) {
    if (std::isfinite(sign == SignRule::none ? band.outside : band.widest())) return;
    Box all = grid.box();
    add(all, mesh);
    const double diagonal =
        std::hypot(all.upper[0] - all.lower[0], all.upper[1] - all.lower[1], all.upper[2] - all.lower[2]);
    if (diagonal > static_cast<double>(std::numeric_limits<float>::max()))
        refuse(
            "grid and mesh have a diagonal of {}, beyond the floats that distances are given in; "
            "scale the mesh, or give the band an end",
            diagonal);
}

}  // namespace

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh, Vertices vertices,
                   Options options)
    : context_(context),
      pool_(std::move(pool)),
      options_(std::move(options)),
      mesh_(kept_, tools(), std::move(mesh), std::move(vertices)) {
    set_sign_surface({});
}

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh,
                   std::shared_ptr<const MeshTopology> topology, Options options)
    : context_(context),
      pool_(std::move(pool)),
      options_(std::move(options)),
      mesh_(kept_, tools(), std::move(mesh), std::move(topology)) {
    set_sign_surface({});
}

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool,
                   std::shared_ptr<const Mesh> given, MadeTopology made, Options options)
    : context_(context),
      pool_(std::move(pool)),
      options_(std::move(options)),
      mesh_(kept_, tools(), std::move(given), std::move(made)) {
    set_sign_surface({});
    keep_only_copies_within_budget();
}

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, RegionPart part, Options options)
    : context_(context),
      pool_(std::move(pool)),
      options_(std::move(options)),
      mesh_(kept_, tools(), std::move(part.mesh.mesh), std::move(part.mesh.topology), std::move(part.mesh.frusta)) {
    set_sign_surface(std::move(part.mesh.surface));
    restriction_.set(std::make_shared<const Restriction>(std::move(part.restriction)));
    set_volume_of_whole(part.encloses_negative_volume);
    if (part.movable) mover_ = std::make_unique<PartMover>(tools(), std::move(part.movable));
    if (part.given_faces) set_given_faces(std::move(*part.given_faces));
    if (part.boundary) {
        OpenLoops loops;  // of whose vertices a part has none
        loops.floor = part.boundary->floor;
        open_loops_.set(std::make_shared<const OpenLoops>(std::move(loops)));
        boundary_.set(std::move(part.boundary));
    }
}

KeptMesh::KeptMesh(device::Context& context, std::shared_ptr<device::BufferPool> pool, BorrowedMesh mesh,
                   BorrowedSites sites, Options options)
    : context_(context), pool_(std::move(pool)), options_(std::move(options)), mesh_(kept_, tools(), std::move(mesh)) {
    set_sign_surface({});
    const auto set = [](auto& kept, device::BufferPool::Lease& lease) {
        if ((*lease)() != nullptr) kept.set(std::make_shared<const device::BufferPool::Lease>(std::move(lease)));
    };
    set(site_names_, sites.names);
    set(pseudonormals_, sites.normals);
}

RegionPart KeptMesh::part_of_regions(std::vector<Region> regions, SignRule sign, double margin) {
    if (margin > 0 && given_faces_)
        refuse_unsupported(
            "a part with a margin is one of the faces as given, and the transform has the surface outer, "
            "whose faces are cut anew when vertices move; make the transform of the mesh of outer()");
    if (margin > 0 && !ways().frusta_by_kernels)
        refuse_unsupported(
            "a part with a margin is one of a mesh of up to {} triangles, and {} has {}; divide "
            "the mesh",
            std::size_t{1} << 28, name(), face_count());
    return prepare([&] {
        Restriction restriction(std::move(regions));
        NearWithinMargin near;
        if (margin > 0) {
            // The mesh may grow by two margins, and with it the gap.
            const double gap = sign_surface_gap() * (1 + 2 * margin / box().longest_side());
            near = near_within_margin(restriction.near_boxes(sign, gap), topology(), frusta(), margin);
            restriction.record_count = near.records.face_count + near.records.site_count;
        } else {
            near.records = restriction.near(index(), sign, sign_surface_gap());
        }
        RegionPart part{part_of(mesh(), sign_surface(), topology(), frusta(), near.records), std::move(restriction),
                        encloses_negative_volume()};
        part.restriction.numbers = part.mesh.triangles;
        part.restriction.sample = surface_sample(topology(), frusta());
        if (given_faces_) part.given_faces = given_faces_->of(part.restriction.numbers);
        part.boundary = boundary();
        if (margin > 0)
            part.movable = std::make_shared<const MovablePart>(make_movable(
                {mesh(), vertices(), sign_surface(), topology(), open_loops_.get().get()}, part.mesh, near, margin));
        return part;
    });
}

RegionPart KeptMesh::own_part() {
    return prepare([&] {
        RegionPart part{{mesh(), sign_surface(), restriction_->numbers, shared_topology(), frusta()},
                        *restriction_.get(),
                        volume_is_unknown_ ? std::nullopt : std::optional(encloses_negative_volume())};
        if (given_faces_) part.given_faces = *given_faces_.get();
        part.boundary = boundary();
        if (mover_) part.movable = mover_->movable();
        return part;
    });
}

Job KeptMesh::checked(JobKey asked, SignRule sign) const {
    if (restriction_) restriction_->check(asked.grid, asked.band, sign);
    Job job{std::move(asked)};
    job.lattice = lattice_of(job.grid);
    check_distance(box(), name(), job.lattice);
    job.layout = layout_of(job.grid, job.band, sign);
    check_unbounded_distances(box(), job.grid, job.band, sign);
    return job;
}

void KeptMesh::move(std::vector<Vec3> positions) {
    mesh_.move(std::move(positions));
    forget_positions();
}

void KeptMesh::move_part(std::span<const Vec3> positions) {
    MovedPart moved = prepare([&] { return mover_->moved(positions, topology(), sign_surface()); });
    auto restriction = std::make_shared<Restriction>(*restriction_.get());
    restriction->sample = std::move(moved.sample);
    mesh_.move(std::move(moved.positions), moved.box);
    forget_positions();
    mesh_.set_frusta(std::move(moved.frusta));
    restriction_.set(std::move(restriction));
    boundary_.set(std::move(moved.boundary));
    set_volume_of_whole(moved.encloses_negative_volume);
}

void KeptMesh::set_volume_of_whole(const std::optional<bool>& is_negative) {
    volume_is_unknown_ = !is_negative;
    if (is_negative) set_encloses_negative_volume(*is_negative);
}

template <class Positions>
bool KeptMesh::move_on_device(const Positions& positions, std::size_t count) {
    if (!sign_surface().vertices.empty() || !mesh_.move_on_device(positions, count)) return false;
    forget_positions();
    return true;
}
template bool KeptMesh::move_on_device(const DeviceTriples&, std::size_t);
template bool KeptMesh::move_on_device(const std::span<const Vec3>&, std::size_t);

void KeptMesh::forget_positions() {
    ++moves_;
    each_kept([](KeptValue& value) {
        if (value.made_of == MadeOf::positions) value.forget();
    });
}

void KeptMesh::keep_only_copies_within_budget() {
    if (only_copy_bytes() > budget()) mesh_.read_only_copies();
}

std::size_t KeptMesh::only_copy_bytes() const {
    std::size_t bytes = 0;
    for (const KeptValue* value : kept_)
        if (!value->can_leave_device()) bytes += value->memory().device_bytes;
    return bytes;
}

void KeptMesh::refuse_memory() const {
    throw Error(ErrorCode::out_of_memory,
                fmt::format("preparing {}, {} triangles, takes more than the host's memory; divide the mesh", name(),
                            face_count()));
}

const ClusterIndex& KeptMesh::index() {
    return *index_.get_or([&] { return mesh_.make_index(); });
}

std::shared_ptr<const DeviceFaces> KeptMesh::device_faces(const LatticeView& lattice) {
    if (options_.method || !ways().frusta_by_kernels || !is_plain(box(), lattice)) return nullptr;
    return mesh_.faces();
}

PreparedMesh KeptMesh::all_records(const LatticeView& lattice) {
    if (!has_frusta() && is_plain(box(), lattice))
        if (std::optional<PreparedMesh> first = mesh_.make_frusta(&lattice)) return std::move(*first);
    return records(lattice, all_ranges());
}

PreparedMesh KeptMesh::records(const LatticeView& lattice, const NearRecords& ranges) {
    if (const auto faces = device_faces(lattice))
        return records_on_device(mesh_.set_up(), *faces, mesh_.written_faces(*faces), lattice, ranges.faces,
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
    const std::size_t faces = face_count(), sites = mesh_.found().sites.size();
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

bool KeptMesh::is_swept_on_device(const Job& job, const DeviceFaces* faces) const {
    return faces != nullptr && sign_surface().is_mesh() && is_within_sweep(box(), job.grid, job.lattice);
}

SweepMesh KeptMesh::sweep_mesh(const Job& job) {
    const auto faces = device_faces(job.lattice);
    return make_sweep_mesh(mesh_.set_up(), job.grid, job.lattice, mesh_, sign_surface(), boundary().get(), faces.get());
}

SweepMesh KeptMesh::near_sweep_mesh(const Job& job, const NearRecords& near) {
    const auto faces = mesh_.is_on_device_alone() && boundary() == nullptr ? device_faces(job.lattice) : nullptr;
    if (is_swept_on_device(job, faces.get()))
        return engine::near_sweep_mesh(mesh_.set_up(), job.grid, job.lattice, box(), *faces, near);
    return engine::near_sweep_mesh(tools(), job.grid, job.lattice, present(), sign_surface(), boundary().get(),
                                   topology(), near.faces);
}

std::optional<CrossedMesh> KeptMesh::crossed_mesh() {
    if (options_.programs.body != KernelBody::by_group || restriction_ || open_loops_ || !sign_surface().is_mesh())
        return std::nullopt;
    return prepare([&] {
        return CrossedMesh{mesh_.names(), mesh_.positions_on_device(), 1 / lattice_for_points(box(), name()).unit};
    });
}

bool KeptMesh::needs_normals(Lattice& lattice) {
    if (!sign_surface().faces.empty()) return true;
    if (!lattice.may_meet_samples)
        lattice.may_meet_samples =
            engine::may_meet_samples(topology(), frusta().positions, lattice.origin, lattice.spacing);
    return *lattice.may_meet_samples;
}

std::shared_ptr<const DeviceTopology> KeptMesh::topology_on_device() const {
    return restriction_ || open_loops_ || !sign_surface().is_mesh() ? nullptr : mesh_.topology_by_kernels();
}

std::shared_ptr<const OpenBoundary> KeptMesh::boundary() {
    if (!open_loops_) return nullptr;
    return boundary_.get_or([&] { return OpenBoundary(*open_loops_, present().positions); });
}

std::shared_ptr<const OpenBoundary> KeptMesh::any_boundary() {
    if (open_loops_) return boundary();
    return boundary_.get_or([&] { return OpenBoundary(open_loops_of(mesh(), sign_surface()), mesh().vertices()); });
}

bool KeptMesh::encloses_negative_volume() {
    if (volume_is_unknown_)
        refuse_unsupported(
            "gradients need the side that the faces of all of {} look to, and motions by up to the "
            "margin {} of this part can turn it inside out; leave gradients out, or restrict the "
            "whole transform with a smaller margin",
            name(), mover_->movable()->margin);
    return *encloses_negative_volume_.get_or([&] { return clsdf::encloses_negative_volume(mesh(), sign_surface()); });
}

std::shared_ptr<const DeviceSites> KeptMesh::sites(bool with_names, bool with_normals) {
    return prepare([&] {
        std::span<const FacePiece> pieces;
        if (given_faces_) pieces = given_faces_->pieces;
        if (with_names) site_names_.get_or([&] { return site_names(tools(), topology(), numbers(), pieces); });
        const std::size_t renumbered = site_names_ && pieces.empty() ? numbers().size() : 0;
        if (with_normals)
            pseudonormals_.get_or([&] { return site_normals(tools(), mesh(), sign_surface(), topology()); });
        return std::make_shared<const DeviceSites>(DeviceSites{site_names_.get(), pseudonormals_.get(), renumbered,
                                                               site_names_ ? pieces.size() : 0,
                                                               pseudonormals_ ? sign_surface().faces.size() : 0});
    });
}

template <class Visit>
void KeptMesh::each_kept(const Visit& visit) {
    for (KeptValue* value : kept_) visit(*value);
    for (Lattice& lattice : lattices_) visit(lattice);
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
    budget -= std::min(budget, only_copy_bytes());
    each_kept([&](KeptValue& value) {
        if (!value.can_leave_device()) return;
        const std::size_t bytes = value.memory().device_bytes;
        if (bytes > budget)
            value.leave_device();
        else
            budget -= bytes;
    });
    mesh_.leave_device_together();
}

void KeptMesh::release() {
    // The last first: before the values whose memory they hold.
    const auto release = [](KeptValue& value) {
        if (!value.is_in_use()) value.leave_device();
    };
    for (Lattice& lattice : std::views::reverse(lattices_)) release(lattice);
    for (KeptValue* value : std::views::reverse(kept_)) release(*value);
}

KeptMemory KeptMesh::memory() {
    KeptMemory sum;
    sum.host_bytes = mesh_.first_position_bytes();
    if (mover_) {
        const KeptMemory memory = mover_->memory();
        sum.host_bytes += memory.host_bytes;
        sum.device_bytes += memory.device_bytes;
    }
    each_kept([&](const KeptValue& value) {
        const KeptMemory memory = value.memory();
        sum.host_bytes += memory.host_bytes;
        sum.device_bytes += memory.device_bytes;
    });
    return sum;
}

bool KeptMesh::keeps(const std::shared_ptr<const PreparedMesh>& records) const {
    return std::ranges::find(lattices_, records, &Lattice::records) != lattices_.end();
}

bool KeptMesh::keeps(const std::shared_ptr<const SweepMesh>& sweep_mesh) const {
    return std::ranges::find(lattices_, sweep_mesh, &Lattice::sweep_mesh) != lattices_.end();
}

std::size_t KeptMesh::record_bytes() const {
    return (restriction_ ? restriction_->record_count : face_count()) * sizeof(Polyhedron);
}

}  // namespace clsdf::engine

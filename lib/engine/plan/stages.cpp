#include "plan/stages.hpp"

#include "mesh/topology.hpp"
#include "plan/field_method.hpp"
#include "polyhedra/sites.hpp"
#include "prepare/layout_of.hpp"
#include "scan/coarse_lists.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace clsdf::transform {

namespace {

/// The box of the samples of a range of blocks of the lattice, in the mesh's units.
Box box_of(const Grid& grid, const std::int32_t* first_block, const std::int32_t* blocks, int block) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = static_cast<double>(first_block[axis]) * block;
        const double last = first + static_cast<double>(blocks[axis]) * block - 1;
        box.lower[axis] = grid.origin[axis] + first * grid.spacing[axis];
        box.upper[axis] = grid.origin[axis] + last * grid.spacing[axis];
    }
    return box;
}

/// Triangles farther than this from a brick, in the mesh's units, decide none of its samples: they are farther than the
/// half width from each, by more than the rounding of distances and of the tests in kernels/lists/coarse_clusters.h.
double greatest_distance_of(const Layout& layout) {
    const auto half_width = static_cast<double>(layout.half_width);
    const double units = half_width * (1 + static_cast<double>(layout.slack_rate)) +
                         static_cast<double>(layout.coarse_slack) + static_cast<double>(layout.brick_slack);
    return units * (1 + 1e-4) * static_cast<double>(layout.unit);
}

/// A selection is worth its while if it leaves most of the mesh out.
bool is_small(double share) {
    return share < 0.5;
}

/// Which part of the mesh's box lies in another box.
double share_of(const Box& mesh, const Box& box) {
    double share = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double length = mesh.upper[axis] - mesh.lower[axis];
        const double common = std::min(mesh.upper[axis], box.upper[axis]) - std::max(mesh.lower[axis], box.lower[axis]);
        if (length > 0) share *= std::clamp(common / length, 0.0, 1.0);
    }
    return share;
}

/// Whether nothing beyond a half width matters.
bool is_bounded(const Layout& layout) {
    return std::isfinite(layout.outside_squared) && std::isfinite(layout.inside_squared);
}

}  // namespace

bool Stages::Lattice::is_in_use() const {
    return records.use_count() > 1 || sweep_mesh.use_count() > 1 || points.use_count() > 1;
}

std::size_t Stages::Lattice::bytes() const {
    return (records ? records->device_bytes() : 0) + (sweep_mesh ? sweep_mesh->device_bytes() : 0) +
           (points ? points->size() * sizeof(SurfacePoint) : 0);
}

Stages::Stages(device::Context& context, std::shared_ptr<device::BufferPool> pool, Mesh mesh, Options options)
    : context_(context), pool_(std::move(pool)), options_(std::move(options)), mesh_(std::move(mesh)) {}

Stages::Stages(device::Context& context, std::shared_ptr<device::BufferPool> pool, polyhedra::MeshPart part,
               Restriction restriction, Options options)
    : context_(context),
      pool_(std::move(pool)),
      options_(std::move(options)),
      mesh_(std::move(part.mesh)),
      restriction_(std::move(restriction)),
      topology_(std::move(part.topology)),
      frusta_(std::make_shared<const polyhedra::Frusta>(std::move(part.frusta))) {}

std::unique_ptr<Stages> Stages::restricted(std::shared_ptr<device::BufferPool> pool, std::vector<Region> regions,
                                           SignRule sign) {
    return prepare([&] {
        // Up to the grids' outermost bricks and the slack of their tests, which is far less than a sample.
        std::vector<Box> boxes, rows;
        for (const Region& region : regions) {
            boxes.push_back(widened(region.box, region.half_width * (1 + 1e-3) + (CLSDF_BRICK + 1) * region.spacing));
            // The sweep's rows are those of the grid's bricks: see near_rows().
            rows.push_back(widened(region.box, (CLSDF_BRICK + 1) * region.spacing));
            rows.back().lower[0] = -std::numeric_limits<double>::infinity();
        }
        Restriction restriction(std::move(regions));
        polyhedra::NearRecords near = index().near(boxes);
        restriction.record_count = near.face_count + near.site_count;
        if (sign != SignRule::none) {
            const polyhedra::NearRecords crossed = index().near(rows);
            near.faces.insert(near.faces.end(), crossed.faces.begin(), crossed.faces.end());
        }
        if (near.faces.empty()) near.faces.push_back({0, 1});  // a mesh has a triangle
        polyhedra::MeshPart part = polyhedra::part_of(mesh_, topology(), frusta(), near);
        restriction.numbers = std::move(part.triangles);
        restriction.sample = surface_sample(topology(), frusta());
        restriction.encloses_negative_volume = clsdf::encloses_negative_volume(mesh_);
        return std::unique_ptr<Stages>(
            new Stages(context_, std::move(pool), std::move(part), std::move(restriction), options_));
    });
}

void Stages::check(const Grid& grid, const Band& band, SignRule sign) const {
    if (restriction_) restriction_->check(grid, band, sign);
    check_distance(mesh_, lattice_of(grid));
    layout_of(grid, band, sign);
}

void Stages::move(std::vector<Vec3> positions) {
    topology();  // of the first positions
    polyhedra::move(mesh_, *topology_, std::move(positions));
    has_moved_ = true;
    lattices_.clear();
    encloses_negative_volume_.reset();
    for (const KeptValue& value : kept_values())
        if (value.of_positions) value.forget();
}

void Stages::refuse_memory() const {
    throw Error(ErrorCode::out_of_memory,
                fmt::format("preparing {}, {} triangles, takes more than the host's memory; divide the mesh",
                            mesh_.name(), mesh_.triangles().size()));
}

std::shared_ptr<const polyhedra::MeshTopology> Stages::shared_topology() {
    if (!topology_) topology_ = std::make_shared<const polyhedra::MeshTopology>(mesh_);
    return topology_;
}

const polyhedra::Frusta& Stages::frusta() {
    if (!frusta_) make_frusta(nullptr);
    return *frusta_;
}

const std::shared_ptr<const DeviceFaces::Names>& Stages::names() {
    topology();
    if (!names_) names_ = std::make_shared<const DeviceFaces::Names>(device_names(set_up(), topology_));
    return names_;
}

std::optional<PreparedMesh> Stages::make_frusta(const polyhedra::LatticeView* lattice) {
    if (!suits_kernels(topology())) {
        frusta_ = std::make_shared<const polyhedra::Frusta>(polyhedra::make_frusta(topology(), mesh_.vertices()));
        return std::nullopt;
    }
    const DeviceSetUp job = set_up();
    if (!frusta_sources_) frusta_sources_ = std::make_shared<const FrustaSources>(job, topology());
    MadeFrusta made = frusta_by_kernels(job, names(), frusta_sources_, mesh_, lattice);
    frusta_ = std::move(made.frusta);
    faces_ = std::make_shared<const DeviceFaces>(std::move(made.faces));
    if (!has_moved_) frusta_sources_.reset();
    return std::move(made.records);
}

const polyhedra::ClusterIndex& Stages::index() {
    if (!index_) index_.emplace(topology(), frusta());
    return *index_;
}

std::shared_ptr<const DeviceFaces> Stages::device_faces(const polyhedra::LatticeView& lattice) {
    if (options_.method || !suits_kernels(topology()) || !is_plain(mesh_, lattice)) return nullptr;
    frusta();
    if (!faces_) faces_ = std::make_shared<const DeviceFaces>(scan::device_faces(set_up(), names(), frusta_));
    return faces_;
}

PreparedMesh Stages::all_records(const polyhedra::LatticeView& lattice) {
    if (!frusta_ && is_plain(mesh_, lattice))
        if (std::optional<PreparedMesh> first = make_frusta(&lattice)) return std::move(*first);
    const polyhedra::RecordRange all{0, topology().order.size()}, sites{0, frusta().sites.size()};
    return records(lattice, {&all, 1}, {&sites, 1});
}

PreparedMesh Stages::records(const polyhedra::LatticeView& lattice, std::span<const polyhedra::RecordRange> of_faces,
                             std::span<const polyhedra::RecordRange> of_sites) {
    if (const auto faces = device_faces(lattice))
        return records_on_device(set_up(), *faces, topology(), frusta(), lattice, of_faces, of_sites);
    return records_by_host(context_, pool_, topology(), frusta(), lattice, of_faces, of_sites);
}

Stages::Lattice& Stages::lattice(const Grid& grid) {
    for (auto it = lattices_.begin(); it != lattices_.end(); ++it)
        if (it->origin == grid.origin && it->spacing == grid.spacing) {
            lattices_.splice(lattices_.begin(), lattices_, it);
            return lattices_.front();
        }
    // A lattice without records is not in the budget, and a caller may use a new lattice in each call.
    constexpr std::size_t most_lattices = 64;
    if (lattices_.size() == most_lattices) lattices_.pop_back();
    lattices_.push_front({grid.origin, grid.spacing, nullptr, nullptr, nullptr, 0, 0});
    return lattices_.front();
}

const polyhedra::NearRecords& Stages::kept_records(const Grid& grid) {
    std::optional<polyhedra::NearRecords>& kept = lattice(grid).kept;
    if (!kept && !restriction_) {
        const std::size_t faces = topology().order.size(), sites = frusta().sites.size();
        kept = polyhedra::NearRecords{{{0, faces}}, {{0, sites}}, faces, sites};
    } else if (!kept) {
        // The slack of their tests is far less than the longest spacing.
        const double slack = *std::max_element(grid.spacing.begin(), grid.spacing.end());
        std::vector<Box> boxes;  // near the bricks with samples in the part's regions
        for (const Region& region : restriction_->regions) {
            Box box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double size = CLSDF_BRICK * grid.spacing[axis];
                // Samples may lie beyond it by the rounding of their positions.
                const auto brick = [&](double position, double slack_of_sample) {
                    return std::floor((position - grid.origin[axis] + slack_of_sample * grid.spacing[axis]) / size);
                };
                box.lower[axis] = grid.origin[axis] + brick(region.box.lower[axis], -1e-3) * size;
                box.upper[axis] = grid.origin[axis] + (brick(region.box.upper[axis], 1e-3) + 1) * size;
            }
            boxes.push_back(widened(box, region.half_width * (1 + 1e-3) + slack));
        }
        kept = index().near(boxes);
    }
    return *kept;
}

Inputs Stages::inputs(const Grid& grid, const Layout& layout, SignRule sign, bool lone) {
    return prepare([&] {
        Inputs inputs;
        if (options_.method)
            inputs.records = options_.method->prepare(*this, grid, layout);
        else
            set_records(grid, layout, lone, inputs);
        if (sign != SignRule::none) set_sweep_mesh(grid, layout, lone, inputs);
        return inputs;
    });
}

bool Stages::is_shared(bool is_kept, std::size_t packed, double most) {
    if (!has_selections()) return false;
    return is_kept || (static_cast<double>(packed) > most && device_bytes() + record_bytes() <= budget());
}

std::optional<polyhedra::NearRecords> Stages::near_box(const Box& box, std::size_t faces) {
    if (options_.is_whole || !is_small(share_of(mesh_.box(), box))) return std::nullopt;
    polyhedra::NearRecords near = index().near(box);
    if (!is_small(static_cast<double>(near.face_count) / static_cast<double>(faces))) return std::nullopt;
    return near;
}

std::optional<polyhedra::NearRecords> Stages::near_bricks(const Grid& grid, const Layout& layout) {
    if (!is_bounded(layout)) return std::nullopt;
    // Near the bricks alone: triangles near the rest of their coarse bricks decide none of the samples.
    return near_box(widened(box_of(grid, layout.brick_first, layout.bricks, CLSDF_BRICK), greatest_distance_of(layout)),
                    restriction_ ? kept_records(grid).face_count : topology().order.size());
}

std::optional<polyhedra::NearRecords> Stages::near_rows(const Grid& grid, const Layout& layout) {
    if (!frusta_) return std::nullopt;
    // Rows run along x: what they cross on the way to the samples.
    Box box = box_of(grid, layout.brick_first, layout.bricks, CLSDF_BRICK);
    box.lower[0] = -std::numeric_limits<double>::infinity();
    auto near = near_box(widened(box, grid.voxel()), topology().order.size());
    return near && is_within_sweep(mesh_, grid) ? std::move(near) : std::nullopt;
}

void Stages::set_records(const Grid& grid, const Layout& layout, bool lone, Inputs& inputs) {
    const polyhedra::LatticeView view = lattice_of(grid);
    Lattice& kept = lattice(grid);
    if (const auto near = near_bricks(grid, layout)) {
        // All cores pack all of them, and one those of a small grid.
        if (!lone && is_shared(kept.records != nullptr, kept.faces_packed + near->face_count,
                               0.25 * static_cast<double>(kept_records(grid).face_count))) {
            inputs.selection = select_records(context_, kept_records(grid), *near);
        } else {
            inputs.records = std::make_shared<const PreparedMesh>(records(view, near->faces, near->sites));
            if (!lone) kept.faces_packed += near->face_count;
        }
    }
    if (!inputs.records && !kept.records)
        kept.records = std::make_shared<const PreparedMesh>(
            restriction_ ? records(view, kept_records(grid).faces, kept_records(grid).sites) : all_records(view));
    if (!inputs.records) inputs.records = kept.records;
    if (has_uniform_bounds(layout)) return;
    if (!kept.points)
        kept.points = std::make_shared<const SurfacePoints>(
            surface_points(restriction_ ? restriction_->sample : surface_sample(topology(), frusta()), view));
    inputs.points = kept.points;
}

void Stages::set_sweep_mesh(const Grid& grid, const Layout& layout, bool lone, Inputs& inputs) {
    Lattice& kept = lattice(grid);
    const auto near = near_rows(grid, layout);
    // A small grid stores three vertices per face; the whole mesh shares them, about half a vertex per face.
    if (near && (lone || !is_shared(kept.sweep_mesh != nullptr, kept.faces_swept + near->face_count,
                                    0.1 * static_cast<double>(topology().order.size())))) {
        inputs.sweep_mesh =
            std::make_shared<const SweepMesh>(near_sweep_mesh(context_, pool_, grid, mesh_, topology(), near->faces));
        if (!lone) kept.faces_swept += near->face_count;
        return;
    }
    if (!kept.sweep_mesh) {
        const auto faces = device_faces(lattice_of(grid));
        kept.sweep_mesh =
            std::make_shared<const SweepMesh>(make_sweep_mesh(set_up(), grid, mesh_, names(), faces.get()));
    }
    inputs.sweep_mesh = kept.sweep_mesh;
    if (near) inputs.sweep_selection = select_triangles(context_, *near);
}

void Stages::select(const Grid& part, const Layout& layout, Inputs& inputs) {
    if (!has_selections() || options_.method) return;
    prepare([&] {
        const Lattice& kept = lattice(part);
        if (inputs.records == kept.records)
            if (const auto near = near_bricks(part, layout))
                inputs.selection = select_records(context_, kept_records(part), *near);
        if (inputs.sweep_mesh && inputs.sweep_mesh == kept.sweep_mesh)
            if (const auto near = near_rows(part, layout)) inputs.sweep_selection = select_triangles(context_, *near);
    });
}

bool Stages::may_meet_samples(const Grid& grid) {
    Lattice& kept = lattice(grid);
    if (!kept.may_meet_samples)
        kept.may_meet_samples = polyhedra::may_meet_samples(topology(), frusta().positions, kept.origin, kept.spacing);
    return *kept.may_meet_samples;
}

bool Stages::encloses_negative_volume() {
    if (!encloses_negative_volume_)
        encloses_negative_volume_ =
            restriction_ ? restriction_->encloses_negative_volume : clsdf::encloses_negative_volume(mesh_);
    return *encloses_negative_volume_;
}

std::shared_ptr<const DeviceSites> Stages::sites(bool with_names, bool with_normals) {
    using Lease = device::BufferPool::Lease;
    return prepare([&] {
        if (with_names && !sites_.names) {
            const auto numbers =
                restriction_ ? std::span<const std::uint32_t>(restriction_->numbers) : std::span<const std::uint32_t>();
            sites_.names = std::make_shared<const Lease>(site_names(context_, pool_, topology(), numbers));
            sites_.renumbered = numbers.size();
        }
        if (with_normals && !sites_.normals) {
            sites_.normals = std::make_shared<const Lease>(site_normals(context_, pool_, topology(), mesh_.vertices()));
        }
        return std::make_shared<const DeviceSites>(sites_);
    });
}

std::vector<Stages::KeptValue> Stages::kept_values() {
    const auto host = [](const auto& value) { return value ? value->bytes() : std::size_t{0}; };
    const auto device = [](const auto& value) { return value ? value->device_bytes() : std::size_t{0}; };
    std::vector<KeptValue> others = others_ ? others_() : std::vector<KeptValue>();
    const bool has_points = !others.empty();
    std::vector<KeptValue> values{
        {"topology", host(topology_), 0, false, false, {}},
        {"names of sites", 0, host(sites_.names), false, has_points, [this] { sites_.names.reset(); }},
        {"pseudonormals", 0, host(sites_.normals), true, has_points, [this] { sites_.normals.reset(); }},
        {"faces' names", 0, host(names_), false, false,
         [this] {
             faces_.reset();  // which use them
             names_.reset();
         }},
        {"faces' positions and slopes", 0, faces_ ? faces_->own_bytes() : 0, true, false, [this] { faces_.reset(); }},
        {"sources of frusta", frusta_sources_ ? frusta_sources_->host_bytes() : 0, device(frusta_sources_), false,
         false, [this] { frusta_sources_.reset(); }},
        {"frusta", host(frusta_), 0, true, false, [this] { frusta_.reset(); }},
        {"index", host(index_), 0, true, false, [this] { index_.reset(); }},
    };
    std::ranges::move(others, std::back_inserter(values));
    return values;
}

std::size_t Stages::budget() {
    std::size_t of_points = 0;
    for (const KeptValue& value : kept_values()) of_points += value.of_points ? value.device_bytes : 0;
    return options_.kept_bytes.value_or(std::max(2 * record_bytes() + of_points, std::size_t{1} << 28));
}

void Stages::keep_within(std::size_t budget) {
    // Returns whether it is within the budget, beside what has been kept so far.
    auto is_kept = [left = budget](std::size_t bytes) mutable {
        if (bytes > left) return false;
        left -= bytes;
        return true;
    };
    for (const KeptValue& value : kept_values())
        if (!is_kept(value.device_bytes)) value.forget();
    std::erase_if(lattices_, [&](const Lattice& lattice) { return !is_kept(lattice.bytes()); });
}

void Stages::release() {
    std::list<Lattice> in_use;
    for (auto it = lattices_.begin(); it != lattices_.end();) {
        const auto lattice = it++;
        if (lattice->is_in_use()) in_use.splice(in_use.end(), lattices_, lattice);
    }
    DeviceSites sites = sites_;
    if (sites.names.use_count() == 2) sites.names.reset();  // of `sites_` and here
    if (sites.normals.use_count() == 2) sites.normals.reset();
    keep_within(0);
    lattices_ = std::move(in_use);
    sites_ = std::move(sites);
}

std::size_t Stages::bytes_beside(const Inputs& inputs) const {
    const auto is_kept = [&](const auto& made) { return std::ranges::any_of(lattices_, made); };
    std::size_t bytes = 0;
    if (inputs.records && !is_kept([&](const Lattice& lattice) { return lattice.records == inputs.records; }))
        bytes += inputs.records->device_bytes();
    if (inputs.sweep_mesh && !is_kept([&](const Lattice& lattice) { return lattice.sweep_mesh == inputs.sweep_mesh; }))
        bytes += inputs.sweep_mesh->device_bytes();
    return bytes;
}

std::size_t Stages::device_bytes() {
    std::size_t bytes = 0;
    for (const KeptValue& value : kept_values()) bytes += value.device_bytes;
    for (const Lattice& lattice : lattices_) bytes += lattice.bytes();
    return bytes;
}

std::size_t Stages::record_bytes() const {
    return (restriction_ ? restriction_->record_count : mesh_.triangles().size()) * sizeof(Polyhedron);
}

std::size_t Stages::host_bytes() {
    std::size_t bytes = 0;
    for (const KeptValue& value : kept_values()) bytes += value.host_bytes;
    for (const Lattice& lattice : lattices_) {
        bytes += sizeof lattice;
        if (lattice.kept)
            bytes += (lattice.kept->faces.size() + lattice.kept->sites.size()) * sizeof(polyhedra::RecordRange);
    }
    if (restriction_)
        bytes += restriction_->numbers.size() * sizeof(std::uint32_t) +
                 restriction_->sample.size() * sizeof(restriction_->sample[0]);
    return bytes;
}

}  // namespace clsdf::transform

#include "transform/prepared_mesh.hpp"

#include "core/parallel.hpp"
#include "device/host_filling.hpp"
#include "polyhedra/frame_batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

namespace clsdf::transform {

namespace {

// Surface points that the coarse bounds look at, at most twice as many: they need not be tight.
constexpr std::size_t most_surface_points = 4096;

// Squares of distances stay far inside a float's range.
constexpr double farthest = 1e14;

/// Room for the point sites of most meshes: one of 240 faces needs one on a noisy scan, one of 1600 on a smooth one.
std::size_t spare_records(std::size_t faces) {
    return 64 + faces / 128;
}

std::size_t in_whole_record_groups(std::size_t count) {
    return (count + polyhedra::record_group - 1) / polyhedra::record_group * polyhedra::record_group;
}

/// Records that the host writes into the device's memory.
class RecordFilling {
public:
    RecordFilling(device::Context& context, std::shared_ptr<device::BufferPool> pool, std::size_t room)
        : context_(context), pool_(std::move(pool)) {
        make_room(room);
    }

    std::span<Polyhedron> records() const { return records_; }

    /// For more records; keeps those that were written.
    void make_room(std::size_t count) {
        if (count <= records_.size() && filling_) return;
        auto larger = std::make_unique<device::HostFilling>(context_, pool_, count * sizeof(Polyhedron), "polyhedra");
        const std::span<Polyhedron> room(static_cast<Polyhedron*>(larger->memory()), count);
        std::copy(records_.begin(), records_.end(), room.begin());
        filling_ = std::move(larger);
        records_ = room;
    }

    /// The groups that `count` face records are, filled up with the last one.
    std::size_t fill_group(std::size_t count) const {
        const std::size_t end = in_whole_record_groups(count);
        for (std::size_t i = count; i < end; ++i) records_[i] = records_[count - 1];
        return end;
    }

    device::BufferPool::Lease finish() { return filling_->finish(); }

private:
    device::Context& context_;
    std::shared_ptr<device::BufferPool> pool_;
    std::unique_ptr<device::HostFilling> filling_;
    std::span<Polyhedron> records_;
};

/// Behind the faces' records, of which there are `count`.
PreparedMesh finish_with_sites(RecordFilling& filling, std::size_t count, const polyhedra::MeshTopology& topology,
                               const polyhedra::Frusta& frusta, const polyhedra::LatticeView& lattice,
                               std::span<const polyhedra::RecordRange> sites) {
    std::size_t end = in_whole_record_groups(count);
    std::size_t site_count = 0;
    for (const polyhedra::RecordRange& range : sites) site_count += range.end - range.begin;
    filling.make_room(end + site_count);
    filling.fill_group(count);
    for (const polyhedra::RecordRange& range : sites) {
        const std::size_t size = range.end - range.begin;
        write_site_records(topology, frusta, lattice, range.begin, filling.records().subspan(end, size));
        end += size;
    }
    PreparedMesh prepared;
    set_counts(topology, frusta, prepared);
    prepared.record_count = end;
    prepared.polyhedra = filling.finish();
    return prepared;
}

}  // namespace

RecordSelection select_records(const device::Context& context, const polyhedra::MeshTopology& topology,
                               const polyhedra::NearRecords& near) {
    std::vector<cl_uint> groups;
    const auto add = [&](const polyhedra::RecordRange& range, std::size_t first_group) {
        for (std::size_t record = range.begin; record < range.end; record += polyhedra::record_group)
            groups.push_back(static_cast<cl_uint>(first_group + record / polyhedra::record_group));
    };
    for (const polyhedra::RecordRange& range : near.faces) add(range, 0);
    const std::size_t first_site = in_whole_record_groups(topology.order.size()) / polyhedra::record_group;
    for (const polyhedra::RecordRange& range : near.sites) add(range, first_site);
    RecordSelection selection;
    selection.group_count = groups.size();
    if (groups.empty()) groups.push_back(0);
    selection.groups = device::copied(context, groups);
    return selection;
}

void set_counts(const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta, PreparedMesh& prepared) {
    prepared.triangle_count = topology.order.size();
    prepared.polyhedron_count = topology.order.size() + frusta.sites.size();
    prepared.saddle_vertices = frusta.saddle_vertices;
    prepared.point_sites = frusta.sites.size();
    prepared.boxes = frusta.boxes;
}

void check_distance(const Mesh& mesh, const polyhedra::LatticeView& lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = (mesh.box().lower[axis] - lattice.origin[axis]) / lattice.unit;
        const double high = (mesh.box().upper[axis] - lattice.origin[axis]) / lattice.unit;
        if (!(std::abs(low) < farthest) || !(std::abs(high) < farthest))
            throw Error(ErrorCode::invalid_argument, fmt::format("{} reaches more than 1e14 voxels from the grid's "
                                                                 "origin on axis {}; use a larger spacing, or a grid "
                                                                 "near the mesh",
                                                                 mesh.name(), "xyz"[axis]));
    }
}

FirstGeometry first_geometry(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                             const polyhedra::MeshTopology& topology, const Mesh& mesh,
                             const polyhedra::LatticeView& lattice) {
    const std::size_t count = topology.order.size();
    RecordFilling filling(context, pool, in_whole_record_groups(count) + spare_records(count));
    const polyhedra::FirstRecords records{lattice, filling.records().first(count)};
    FirstGeometry geometry{polyhedra::make_frusta(topology, mesh.vertices(), &records), {}};
    const polyhedra::RecordRange sites{0, geometry.frusta.sites.size()};
    geometry.records = finish_with_sites(filling, count, topology, geometry.frusta, lattice, {&sites, 1});
    return geometry;
}

PreparedMesh all_records(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                         const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                         const polyhedra::LatticeView& lattice) {
    const std::size_t count = topology.order.size();
    RecordFilling filling(context, pool, in_whole_record_groups(count) + frusta.sites.size());
    for_each_range(count, [&](std::size_t begin, std::size_t end) {
        write_face_records(topology, frusta, lattice, begin, filling.records().subspan(begin, end - begin));
    });
    const polyhedra::RecordRange sites{0, frusta.sites.size()};
    return finish_with_sites(filling, count, topology, frusta, lattice, {&sites, 1});
}

PreparedMesh near_records(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                          const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                          const polyhedra::LatticeView& lattice, const polyhedra::NearRecords& near) {
    RecordFilling filling(context, pool, in_whole_record_groups(near.face_count) + near.site_count);
    // Ranges of like size, for all cores.
    struct Piece {
        std::size_t first;
        std::size_t record;
        std::size_t count;
    };
    constexpr std::size_t size = 256;
    std::vector<Piece> pieces;
    std::size_t record = 0;
    for (const polyhedra::RecordRange& range : near.faces)
        for (std::size_t begin = range.begin; begin < range.end; begin += size) {
            const std::size_t count = std::min(size, range.end - begin);
            pieces.push_back({begin, record, count});
            record += count;
        }
    const auto write = [&](const Piece& piece) {
        write_face_records(topology, frusta, lattice, piece.first,
                           filling.records().subspan(piece.record, piece.count));
    };
    // A thread is woken for some hundred microseconds of work, not for less.
    if (near.face_count < 2048)
        std::for_each(pieces.begin(), pieces.end(), write);
    else
        for_each_stretch(pieces.size(), 1, [&](std::size_t i, std::size_t, std::size_t) { write(pieces[i]); });
    return finish_with_sites(filling, near.face_count, topology, frusta, lattice, near.sites);
}

SurfaceSample surface_sample(const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta) {
    const std::size_t faces = topology.order.size();
    const std::size_t stride = std::max<std::size_t>(1, faces / most_surface_points);
    SurfaceSample sample(stretch_count(faces, stride));
    for_each_index(sample.size(), [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) sample[i][k] = frusta.positions[topology.faces.triangles[i * stride][k]];
    });
    return sample;
}

SurfacePoints surface_points(const SurfaceSample& sample, const polyhedra::LatticeView& lattice) {
    SurfacePoints points(sample.size());
    for_each_index(points.size(), [&](std::size_t i) {
        constexpr Triangle corners{0, 1, 2};
        polyhedra::TriangleFrame frame;
        polyhedra::triangle_frames(sample[i], {&corners, 1}, lattice, {&frame, 1});
        const Polyhedron record = polyhedra::pack(frame, {}, 0, sample[i], corners, lattice);
        points[i] = {{record.origin_x, record.origin_y, record.origin_z},
                     {record.foot[0], record.foot[1], record.foot[2]}};
    });
    return points;
}

}  // namespace clsdf::transform

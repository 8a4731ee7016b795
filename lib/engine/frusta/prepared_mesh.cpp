#include "frusta/prepared_mesh.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "device/buffer_pool.hpp"
#include "frusta/frames.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

namespace clsdf::engine {

RecordSelection select_records(const device::Context& context, const NearRecords& kept, const NearRecords& near) {
    std::vector<cl_uint> groups;
    std::size_t first_group = 0;  // of a range that is kept
    const auto add = [&](const std::vector<RecordRange>& of_kept, const std::vector<RecordRange>& wanted) {
        auto range = wanted.begin();
        for (const RecordRange& all : of_kept) {
            for (; range != wanted.end() && range->begin < all.end; ++range)
                for (std::size_t record = range->begin; record < range->end; record += record_group)
                    groups.push_back(static_cast<cl_uint>(first_group + (record - all.begin) / record_group));
            first_group += chunk_count(all.end - all.begin, record_group);
        }
    };
    add(kept.faces, near.faces);
    add(kept.sites, near.sites);
    RecordSelection selection;
    selection.group_count = groups.size();
    if (groups.empty()) groups.push_back(0);
    selection.groups = device::copied(context, groups);
    return selection;
}

void set_counts(std::size_t faces, const FoundFrusta& frusta, PreparedMesh& prepared) {
    prepared.triangle_count = faces;
    prepared.point_sites =
        frusta.sites.size() - static_cast<std::size_t>(std::ranges::count_if(frusta.sites, is_filling));
    prepared.polyhedron_count = faces + prepared.point_sites;
    prepared.saddle_vertices = frusta.saddle_vertices;
    prepared.boxes = frusta.boxes;
}

void check_distance(const Box& box, const std::string& mesh_name, const LatticeView& lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = (box.lower[axis] - lattice.origin[axis]) / lattice.unit;
        const double high = (box.upper[axis] - lattice.origin[axis]) / lattice.unit;
        if (!(std::abs(low) < farthest) || !(std::abs(high) < farthest))
            refuse(
                "{} reaches more than 1e14 voxels from the grid's "
                "origin on axis {}; use a larger spacing, or a grid "
                "near the mesh",
                mesh_name, "xyz"[axis]);
    }
}

PreparedMesh records_by_host(const DeviceTools& tools, const MeshTopology& topology, const Frusta& frusta,
                             const LatticeView& lattice, std::span<const RecordRange> of_faces,
                             std::span<const RecordRange> of_sites) {
    std::size_t count = 0;
    for (const RecordRange& range : of_faces) count += in_record_groups(range.end - range.begin);
    for (const RecordRange& range : of_sites) count += range.end - range.begin;
    device::HostFilling filling(tools.context, tools.pool, count * sizeof(Polyhedron), "polyhedra");
    auto* record = static_cast<Polyhedron*>(filling.memory());
    for (const auto& [begin, end] : of_faces) {
        const std::size_t size = end - begin;
        for_each_index(size, [&, first = begin](std::size_t i) {
            write_face_record(topology, frusta, lattice, first + i, record[i]);
        });
        std::fill(record + size, record + in_record_groups(size), Polyhedron(record[size - 1]));
        record += in_record_groups(size);
    }
    for (const auto& [begin, end] : of_sites) {
        write_site_records(topology, frusta, lattice, begin, {record, end - begin});
        record += end - begin;
    }
    PreparedMesh prepared;
    set_counts(topology.order.size(), frusta, prepared);
    prepared.record_count = count;
    prepared.polyhedra = filling.finish();
    return prepared;
}

}  // namespace clsdf::engine

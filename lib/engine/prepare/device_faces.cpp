#include "prepare/device_faces.hpp"

#include "core/parallel.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace clsdf::scan {

namespace {

void enqueue_faces(const DeviceSetUp& job, const DeviceFaces& faces, const polyhedra::LatticeView& lattice,
                   const std::vector<cl_uint>& groups, const cl::Buffer& records) {
    const auto group_numbers = job.upload(groups, "numbers of the faces");
    cl::Kernel kernel(job.program, "face_records");
    ShortLaunches(job.context, {})
        .over(groups.size(), seconds_per_face * polyhedra::record_group, [&](std::size_t begin, std::size_t end) {
            const std::size_t first = begin * polyhedra::record_group, last = end * polyhedra::record_group;
            launch(job.context.queue(), kernel, job.items_of(last - first), polyhedra::face_lattice(lattice),
                   static_cast<cl_uint>(first), static_cast<cl_uint>(last),
                   static_cast<cl_uint>(faces.names->face_count()), static_cast<cl_uint>(job.item_faces()),
                   *group_numbers, *faces.names->triangles, *faces.positions, *faces.slopes, *faces.names->names,
                   records);
        });
}

/// Records that the host writes into those on the device, or what they are made of.
template <class Value>
struct ByHost {
    std::vector<Value> values;
    std::vector<cl_uint> places;

    void add(const Value& value, std::size_t place) {
        values.push_back(value);
        places.push_back(static_cast<cl_uint>(place));
    }
};

}  // namespace

DeviceFaces::Names device_names(const DeviceSetUp& job, std::shared_ptr<const polyhedra::MeshTopology> topology) {
    const std::size_t count = topology->order.size();
    device::HostFilling filling(job.context, job.pool, count * sizeof(cl_uint), "numbers of the triangles");
    auto* const names = static_cast<cl_uint*>(filling.memory());
    for_each_index(count, [&](std::size_t face) {
        names[face] = topology->order[face] | (topology->edges.is_non_manifold(face) ? CLSDF_NAME_NON_MANIFOLD : 0U);
    });
    auto triangles = job.input(topology->faces.triangles, "triangles");
    return {std::move(topology), std::move(triangles), filling.finish()};
}

DeviceFaces device_faces(const DeviceSetUp& job, std::shared_ptr<const DeviceFaces::Names> names,
                         const polyhedra::Frusta& frusta) {
    return {std::move(names), job.input(frusta.positions, "vertices"),
            job.input(frusta.slopes, "slopes of the polyhedra")};
}

void place_words(const DeviceSetUp& job, const cl::Buffer& written, const cl::Buffer& places, std::size_t count,
                 std::size_t item_words, const cl::Buffer& items) {
    cl::Kernel kernel(job.program, "place_items");
    launch(job.context.queue(), kernel, {count}, static_cast<cl_uint>(count), static_cast<cl_uint>(item_words), written,
           places, items);
}

bool is_plain(const Mesh& mesh, const polyhedra::LatticeView& lattice) {
    double greatest_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = mesh.box().lower[axis], high = mesh.box().upper[axis];
        const double reach = std::max(std::abs(low - lattice.origin[axis]), std::abs(high - lattice.origin[axis]));
        if (!(reach / lattice.unit <= polyhedra::LatticeView::far / 2)) return false;
        greatest_side = std::max(greatest_side, high - low);
    }
    return std::isfinite(1 / lattice.unit) && lattice.unit <= 1e20 * greatest_side;
}

PreparedMesh records_on_device(const DeviceSetUp& job, const DeviceFaces& faces,
                               const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                               const polyhedra::LatticeView& lattice, std::span<const polyhedra::RecordRange> of_faces,
                               std::span<const polyhedra::RecordRange> of_sites) {
    constexpr std::size_t group = polyhedra::record_group;
    std::vector<cl_uint> groups;
    ByHost<std::uint32_t> slivers;
    for (const polyhedra::RecordRange& range : of_faces) {
        const std::size_t first_record = groups.size() * group;
        for (std::size_t face = range.begin; face < range.end; face += group)
            groups.push_back(static_cast<cl_uint>(face / group));
        auto sliver = std::ranges::lower_bound(frusta.slivers, range.begin);
        for (; sliver != frusta.slivers.end() && *sliver < range.end; ++sliver) {
            slivers.add(*sliver, first_record + *sliver - range.begin);
            if (*sliver + 1 < topology.order.size()) continue;
            for (std::size_t n = range.end; n % group != 0; ++n)  // the mesh's last face fills up its group
                slivers.add(*sliver, first_record + n - range.begin);
        }
    }
    PreparedMesh prepared;
    prepared.record_count = groups.size() * group;
    ByHost<Polyhedron> sites;
    for (const polyhedra::RecordRange& range : of_sites) {
        std::vector<Polyhedron> records(range.end - range.begin);
        write_site_records(topology, frusta, lattice, range.begin, records);
        for (const Polyhedron& record : records) sites.add(record, prepared.record_count++);
    }
    std::vector<Polyhedron> sliver_records(slivers.values.size());
    for_each_index(sliver_records.size(), [&](std::size_t i) {
        write_face_record(topology, frusta, lattice, slivers.values[i], sliver_records[i]);
    });
    prepared.polyhedra = job.pool->lease(prepared.record_count * sizeof(Polyhedron), "polyhedra");
    set_counts(topology, frusta, prepared);
    device::guarded([&] {
        if (!groups.empty()) enqueue_faces(job, faces, lattice, groups, *prepared.polyhedra);
        place_items(job, sliver_records, slivers.places, *prepared.polyhedra);
        place_items(job, sites.values, sites.places, *prepared.polyhedra);
    });
    return prepared;
}

}  // namespace clsdf::scan

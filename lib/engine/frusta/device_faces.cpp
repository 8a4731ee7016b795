#include "frusta/device_faces.hpp"

#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

void enqueue_faces(const DeviceSetUp& set_up, const DeviceFaces& faces, const LatticeView& lattice,
                   const std::vector<cl_uint>& groups, const cl::Buffer& records) {
    const auto group_numbers = set_up.upload(groups, "numbers of the faces");
    device::LentKernel kernel = set_up.tools.kernel(set_up.tools.programs.face_records, "face_records");
    ShortLaunches(set_up.tools.context, {})
        .over(groups.size(), seconds_per_face * record_group, [&](std::size_t begin, std::size_t end) {
            const std::size_t first = begin * record_group, last = end * record_group;
            launch(set_up.tools.context.queue(), kernel, set_up.items_of(last - first), face_lattice(lattice),
                   static_cast<cl_uint>(first), static_cast<cl_uint>(last),
                   static_cast<cl_uint>(faces.names->face_count), static_cast<cl_uint>(set_up.ways.item_faces),
                   *group_numbers, *faces.names->triangles, **faces.positions, *faces.slopes, *faces.names->names,
                   records);
        });
}

}  // namespace

DeviceFaces device_faces(const DeviceSetUp& set_up, std::shared_ptr<const NamedFaces> names,
                         std::shared_ptr<const device::BufferPool::Lease> positions,
                         const std::shared_ptr<const Frusta>& frusta) {
    if (!positions)
        positions = std::make_shared<const device::BufferPool::Lease>(set_up.shared(frusta, frusta->positions));
    return {std::move(names), std::move(positions), set_up.input(frusta, frusta->slopes, "slopes of the polyhedra"),
            frusta};
}

Frusta DeviceFaces::read(const DeviceSetUp& set_up) const {
    Frusta frusta;
    static_cast<FoundFrusta&>(frusta) = *found;
    frusta.positions = UninitializedVector<Vec3>(names->vertex_count);
    frusta.slopes = UninitializedVector<FaceSlopes>(names->face_count);
    set_up.tools.context.run_or_drain([&] {
        device::read_values(set_up.tools.context, **positions, frusta.positions);
        device::read_values(set_up.tools.context, *slopes, frusta.slopes);
    });
    return frusta;
}

void place_words(const DeviceSetUp& set_up, const cl::Buffer& written, const cl::Buffer& places, std::size_t count,
                 std::size_t item_words, const cl::Buffer& items) {
    device::LentKernel kernel = set_up.tools.kernel(set_up.tools.programs.face_records, "place_items");
    launch(set_up.tools.context.queue(), kernel, {count}, static_cast<cl_uint>(count), static_cast<cl_uint>(item_words),
           written, places, items);
}

void WrittenRecords::add_faces(const RecordRange& range, std::size_t record) {
    const auto add = [&](std::uint32_t face, std::size_t place) {
        written_faces_.push_back(face);
        face_places_.push_back(static_cast<cl_uint>(record + place - range.begin));
    };
    const auto end = std::lower_bound(faces_.begin(), faces_.end(), range.end);
    for (auto face = std::lower_bound(faces_.begin(), faces_.end(), range.begin); face != end; ++face)
        add(*face, *face);
    if (faces_.empty() || faces_.back() + 1 != range.end) return;
    for (std::size_t place = range.end; place % record_group != 0; ++place) add(faces_.back(), place);
}

void WrittenRecords::add_sites(const RecordRange& range, std::size_t record) {
    const std::size_t size = range.end - range.begin, first = sites_.size();
    sites_.resize(first + size);
    write_site_records(from_.topology, from_.frusta, lattice_, range.begin, std::span(sites_).subspan(first, size));
    for (std::size_t i = 0; i < size; ++i) site_places_.push_back(static_cast<cl_uint>(record + i));
}

void WrittenRecords::place(const DeviceSetUp& set_up, const cl::Buffer& records) const {
    std::vector<Polyhedron> faces(written_faces_.size());
    for_each_index(faces.size(), [&](std::size_t i) {
        write_face_record(from_.topology, from_.frusta, lattice_, from_.number_of(written_faces_[i]), faces[i]);
    });
    place_items(set_up, faces, face_places_, records);
    place_items(set_up, sites_, site_places_, records);
}

bool is_plain(const Box& box, const LatticeView& lattice) {
    double greatest_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = box.lower[axis], high = box.upper[axis];
        const double reach = std::max(std::abs(low - lattice.origin[axis]), std::abs(high - lattice.origin[axis]));
        if (!(reach / lattice.unit <= LatticeView::far / 2)) return false;
        greatest_side = std::max(greatest_side, high - low);
    }
    return std::isfinite(1 / lattice.unit) && lattice.unit <= 1e20 * greatest_side;
}

PreparedMesh records_on_device(const DeviceSetUp& set_up, const DeviceFaces& faces, const WrittenFaces& from,
                               const LatticeView& lattice, std::span<const RecordRange> of_faces,
                               std::span<const RecordRange> of_sites) {
    constexpr std::size_t group = record_group;
    WrittenRecords written(from, lattice, faces.found->slivers);
    std::vector<cl_uint> groups;
    for (const RecordRange& range : of_faces) {
        written.add_faces(range, groups.size() * group);
        for (std::size_t face = range.begin; face < range.end; face += group)
            groups.push_back(static_cast<cl_uint>(face / group));
    }
    PreparedMesh prepared;
    prepared.from_kept_frusta = true;
    prepared.record_count = groups.size() * group;
    for (const RecordRange& range : of_sites) {
        written.add_sites(range, prepared.record_count);
        prepared.record_count += range.end - range.begin;
    }
    prepared.polyhedra = set_up.tools.pool->lease(prepared.record_count * sizeof(Polyhedron), "polyhedra");
    set_counts(faces.names->face_count, *faces.found, prepared);
    device::guarded([&] {
        if (!groups.empty()) enqueue_faces(set_up, faces, lattice, groups, *prepared.polyhedra);
        written.place(set_up, *prepared.polyhedra);
    });
    return prepared;
}

std::vector<Box> cluster_boxes(const DeviceSetUp& set_up, const DeviceFaces& faces) {
    static_assert(sizeof(Box) == 6 * sizeof(double));
    const DeviceTools& tools = set_up.tools;
    const std::size_t count = chunk_count(faces.names->face_count, ClusterIndex::cluster),
                      group = tools.programs.group_size;
    std::vector<Box> result(count);
    tools.context.run_or_drain([&] {
        const auto boxes = tools.pool->lease(count * sizeof(Box), "boxes of clusters");
        device::LentKernel kernel = tools.kernel(tools.programs.mesh_topology, "cluster_boxes");
        launch(tools.queue(), kernel, {count * group, group}, static_cast<cl_uint>(faces.names->face_count),
               *faces.names->triangles, **faces.positions, *boxes);
        device::read_values(set_up.tools.context, *boxes, result);
    });
    return result;
}

}  // namespace clsdf::engine

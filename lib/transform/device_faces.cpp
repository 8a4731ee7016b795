#include "transform/device_faces.hpp"

#include "core/parallel.hpp"
#include "device/host_filling.hpp"
#include "transform/programs.hpp"
#include "transform/short_launches.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf::transform {

namespace {

static_assert(CLSDF_RECORD_GROUP == polyhedra::record_group);

// Of a core, rounded up.
constexpr double seconds_per_face = 1e-6;

/// Copies values to the device, and does not wait.
template <class Values>
device::BufferPool::Lease upload(const DeviceSetUp& job, const Values& values, const char* purpose) {
    using Value = std::remove_cvref_t<decltype(values[0])>;
    device::HostFilling filling(job.context, job.pool, values.size() * sizeof(Value), purpose);
    std::copy(values.begin(), values.end(), static_cast<Value*>(filling.memory()));
    return filling.finish();
}

/// The records that the host writes: of faces that are nearly degenerate, and of point sites.
class WrittenRecords {
public:
    WrittenRecords(const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                   const polyhedra::LatticeView& lattice)
        : topology_(topology), frusta_(frusta), lattice_(lattice) {}

    /// Those of a range of faces, whose records are at `record` and behind. The last face of the mesh fills up its
    /// group.
    void add_faces(const polyhedra::RecordRange& range, std::size_t record) {
        const std::vector<std::uint32_t>& slivers = frusta_.slivers;
        const auto end = std::lower_bound(slivers.begin(), slivers.end(), range.end);
        for (auto sliver = std::lower_bound(slivers.begin(), slivers.end(), range.begin); sliver != end; ++sliver)
            add(*sliver, record + *sliver - range.begin);
        if (slivers.empty() || slivers.back() + 1 != range.end) return;
        for (std::size_t face = range.end; face % polyhedra::record_group != 0; ++face)
            add(slivers.back(), record + face - range.begin);
    }

    void add_sites(const polyhedra::RecordRange& range, std::size_t record) {
        const std::size_t size = range.end - range.begin, first = records_.size();
        records_.resize(first + size);
        write_site_records(topology_, frusta_, lattice_, range.begin, std::span(records_).subspan(first, size));
        for (std::size_t i = 0; i < size; ++i) places_.push_back(static_cast<cl_uint>(record + i));
    }

    /// Enqueues their way to their places.
    void place(const DeviceSetUp& job, const cl::Buffer& records) const {
        if (places_.empty()) return;
        const auto written = upload(job, records_, "records that the host writes");
        const auto places = upload(job, places_, "their places");
        cl::Kernel kernel(job.program, "place_records");
        kernel.setArg(0, static_cast<cl_uint>(places_.size()));
        kernel.setArg(1, *written);
        kernel.setArg(2, *places);
        kernel.setArg(3, records);
        job.context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(in_whole_groups(places_.size())),
                                                 cl::NDRange(common_group));
    }

private:
    void add(std::uint32_t face, std::size_t record) {
        records_.emplace_back();
        write_face_records(topology_, frusta_, lattice_, face, {&records_.back(), 1});
        places_.push_back(static_cast<cl_uint>(record));
    }

    const polyhedra::MeshTopology& topology_;
    const polyhedra::Frusta& frusta_;
    const polyhedra::LatticeView& lattice_;
    std::vector<Polyhedron> records_;
    std::vector<cl_uint> places_;
};

void enqueue_faces(const DeviceSetUp& job, const DeviceFaces& faces, const polyhedra::LatticeView& lattice,
                   const std::vector<cl_uint>& groups, const cl::Buffer& records) {
    const auto group_numbers = upload(job, groups, "numbers of the faces");
    cl::Kernel kernel(job.program, "face_records");
    enum Argument : cl_uint {
        in_lattice,
        begins,
        ends,
        count,
        item_records,
        of_groups,
        triangles,
        positions,
        slopes,
        names,
        out
    };
    kernel.setArg(in_lattice, face_lattice(lattice));
    kernel.setArg(count, static_cast<cl_uint>(faces.names->face_count));
    kernel.setArg(item_records, static_cast<cl_uint>(job.item_faces()));
    kernel.setArg(of_groups, *group_numbers);
    kernel.setArg(triangles, *faces.names->triangles);
    kernel.setArg(positions, *faces.positions);
    kernel.setArg(slopes, *faces.slopes);
    kernel.setArg(names, *faces.names->names);
    kernel.setArg(out, records);
    ShortLaunches(job.context, {})
        .over(groups.size(), seconds_per_face * polyhedra::record_group, [&](std::size_t begin, std::size_t end) {
            const std::size_t first = begin * polyhedra::record_group, last = end * polyhedra::record_group;
            kernel.setArg(begins, static_cast<cl_uint>(first));
            kernel.setArg(ends, static_cast<cl_uint>(last));
            job.enqueue(kernel, last - first);
        });
}

}  // namespace

void DeviceSetUp::enqueue(const cl::Kernel& kernel, std::size_t faces) const {
    const std::size_t group = lanes == 1 ? common_group : 1;
    const std::size_t items = in_whole_groups((faces + item_faces() - 1) / item_faces(), group);
    context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(group));
}

DeviceFaces::Names upload_names(const DeviceSetUp& job, const polyhedra::MeshTopology& topology) {
    const std::size_t count = topology.order.size();
    device::HostFilling filling(job.context, job.pool, count * sizeof(cl_uint), "numbers of the triangles");
    auto* const names = static_cast<cl_uint*>(filling.memory());
    for_each_index(count, [&](std::size_t face) {
        const auto& marks = topology.edges.faces[face].marks;
        const bool is_non_manifold = ((marks[0] | marks[1] | marks[2]) & polyhedra::edge_non_manifold) != 0;
        names[face] = topology.order[face] | (is_non_manifold ? CLSDF_NAME_NON_MANIFOLD : 0U);
    });
    return {upload(job, topology.faces.triangles, "triangles"), filling.finish(), count,
            topology.faces.vertices.size()};
}

DeviceFaces upload_faces(const DeviceSetUp& job, std::shared_ptr<const DeviceFaces::Names> names,
                         const polyhedra::Frusta& frusta) {
    return {std::move(names), upload(job, frusta.positions, "vertices"),
            upload(job, frusta.slopes, "slopes of the polyhedra")};
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

FaceLattice face_lattice(const polyhedra::LatticeView& lattice) {
    FaceLattice result{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.origin[axis] = lattice.origin[axis];
        result.spacing[axis] = lattice.spacing_in_units[axis];
        result.sample[axis] = lattice.spacing_in_units[axis] * lattice.unit;  // exact: a unit is a power of two
    }
    result.per_unit = 1 / lattice.unit;
    return result;
}

PreparedMesh records_on_device(const DeviceSetUp& job, const DeviceFaces& faces,
                               const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta,
                               const polyhedra::LatticeView& lattice, std::span<const polyhedra::RecordRange> of_faces,
                               std::span<const polyhedra::RecordRange> of_sites) {
    constexpr std::size_t group = polyhedra::record_group;
    WrittenRecords written(topology, frusta, lattice);
    std::vector<cl_uint> groups;
    for (const polyhedra::RecordRange& range : of_faces) {
        written.add_faces(range, groups.size() * group);
        for (std::size_t face = range.begin; face < range.end; face += group)
            groups.push_back(static_cast<cl_uint>(face / group));
    }
    PreparedMesh prepared;
    prepared.record_count = groups.size() * group;
    for (const polyhedra::RecordRange& range : of_sites) {
        written.add_sites(range, prepared.record_count);
        prepared.record_count += range.end - range.begin;
    }
    prepared.polyhedra = job.pool->lease(prepared.record_count * sizeof(Polyhedron), "polyhedra");
    set_counts(topology, frusta, prepared);
    device::guarded([&] {
        if (!groups.empty()) enqueue_faces(job, faces, lattice, groups, *prepared.polyhedra);
        written.place(job, *prepared.polyhedra);
    });
    return prepared;
}

}  // namespace clsdf::transform

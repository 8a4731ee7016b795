#include "sign/sweep_mesh.hpp"

#include "core/least_index.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "device/buffer_pool.hpp"
#include "lattice/layout_of.hpp"
#include "launch/short_launches.hpp"
#include "layout.h"
#include "sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace clsdf::engine {

namespace {

// A vertex moves by at most 2^-21 of the smallest spacing on each axis.
constexpr int snap_bits = 20;
// The limit of snapped coordinates: their differences fit 63 bits, with room for the grid's.
constexpr double snapped_limit = 0x1p61;
constexpr double seconds_per_vertex = 1e-7;  // of a core, rounded up
constexpr const char* vertices_purpose = "vertices of the sign's sweep";

/// Bits below a sample on an axis whose spacing is `ratio` voxels.
int bits_of(double ratio) {
    return snap_bits + static_cast<int>(std::ceil(std::log2(std::max(ratio, 1.0))));
}

/// A place on an axis of the lattice, in samples: the sum of both. Two doubles keep the fraction exact far away.
struct Place {
    double sample;  // 0 unless far; else the nearest whole number, up to a rounding
    double past;
};

Place place_of(double position, const Grid& grid, const LatticeView& lattice, std::size_t axis) {
    const double samples = (position - grid.origin[axis]) / grid.spacing[axis];
    const double spacing = lattice.spacing_in_units[axis];
    if (!(std::abs(samples) * spacing > LatticeView::far)) return {0, samples};
    const double sample = std::nearbyint(samples);
    return {sample, lattice.from_sample(axis, position, sample) / spacing};
}

/// The sample that x is counted from: 0, or a sample at the near end of a mesh that is far from it. Crossings are
/// formed from these numbers, so small numbers keep their rounding small.
std::int32_t first_x_of(const Box& box, const Grid& grid, const LatticeView& lattice) {
    const auto samples = [&](double position) { return (position - grid.origin[0]) / grid.spacing[0]; };
    const double nearest = std::max(samples(box.lower[0]), std::min(samples(box.upper[0]), 0.0));
    if (!(std::abs(nearest) * lattice.spacing_in_units[0] > LatticeView::far)) return 0;
    // No grid reaches farther, and its samples' distances from here fit 32 bits.
    constexpr double limit = 1 << 30;
    return CLSDF_BRICK * static_cast<std::int32_t>(std::clamp(nearest, -limit, limit) / CLSDF_BRICK);
}

/// A lattice as the sweep sees it.
struct SweepLattice {
    SweepLattice(const Grid& grid_in, const LatticeView& view_in, const Box& box)
        : grid(grid_in),
          view(view_in),
          bits_y(bits_of(grid.spacing[1] / grid.voxel())),
          bits_z(bits_of(grid.spacing[2] / grid.voxel())),
          first_x(first_x_of(box, grid, view)),
          scale_y(std::ldexp(1.0, bits_y)),
          scale_z(std::ldexp(1.0, bits_z)) {}

    Place place(std::size_t axis, double position) const { return place_of(position, grid, view, axis); }

    static std::int64_t snapped(const Place& at, double scale) {
        return static_cast<std::int64_t>(at.sample * scale) +
               static_cast<std::int64_t>(std::nearbyint(at.past * scale));
    }

    /// Whether the vertex lies within the sweep's integers; then `vertex` is set, and how far it is moved across the
    /// row, unless that is null.
    bool snap(const Vec3& position, SweepVertex& vertex, LatticeCorner* corner = nullptr) const {
        const Place on_x = place(0, position[0]), on_y = place(1, position[1]), on_z = place(2, position[2]);
        if (!(std::abs(std::nearbyint((on_y.sample + on_y.past) * scale_y)) < snapped_limit) ||
            !(std::abs(std::nearbyint((on_z.sample + on_z.past) * scale_z)) < snapped_limit))
            return false;
        vertex = {snapped(on_y, scale_y), snapped(on_z, scale_z), (on_x.sample - first_x) + on_x.past};
        if (corner == nullptr) return true;
        const auto rest = [](const Place& at, double scale) {
            return (at.past * scale - std::nearbyint(at.past * scale)) / scale;
        };
        *corner = {vertex, rest(on_y, scale_y), rest(on_z, scale_z)};
        return true;
    }

    /// Below all vertices; at the limit of the sweep's integers if it is beyond.
    std::int64_t snapped_floor(double z) const {
        const Place at = place(2, z);
        if (!((at.sample + at.past) * scale_z > -snapped_limit)) return -static_cast<std::int64_t>(snapped_limit);
        return snapped(at, scale_z);
    }

    const Grid& grid;
    const LatticeView& view;
    int bits_y, bits_z;
    std::int32_t first_x;
    double scale_y, scale_z;
};

[[noreturn]] void refuse_far(const std::string& mesh_name, const std::string& vertex) {
    refuse_unsupported(
        "{} of {} lies more than 2^40 voxels from the grid's origin, too far for an exact sign; use "
        "a larger spacing or an unsigned field",
        vertex, mesh_name);
}

/// Those of the mesh's vertices, numbered as the faces. Throws if one is beyond the sweep's integers.
device::BufferPool::Lease sweep_vertices(const DeviceSetUp& set_up, const SweepLattice& lattice,
                                         const PlacedVertices& mesh, const SignSurface& surface,
                                         std::span<const std::uint32_t> numbers) {
    device::HostFilling filling(set_up.tools.context, set_up.tools.pool, numbers.size() * sizeof(SweepVertex),
                                vertices_purpose);
    auto* const vertices = static_cast<SweepVertex*>(filling.memory());
    const std::size_t none = mesh.positions.size();
    LeastIndex far(none);
    for_each_index(numbers.size(), [&](std::size_t v) {
        if (!lattice.snap(mesh.positions[surface.vertex(numbers[v])], vertices[v])) far.take(numbers[v]);
    });
    if (far.get() != none) refuse_far(mesh.name, fmt::format("vertex {}", far.get()));
    return filling.finish();
}

/// The same by a kernel, from the positions on the device. The mesh must be near sample (0, 0, 0).
device::BufferPool::Lease vertices_on_device(const DeviceSetUp& set_up, const SweepLattice& lattice,
                                             const DeviceFaces& faces) {
    const std::size_t count = faces.names->vertex_count;
    auto vertices = set_up.tools.pool->lease(count * sizeof(SweepVertex), vertices_purpose);
    device::LentKernel kernel = set_up.tools.kernel(set_up.tools.programs.face_records, "sweep_vertices");
    ShortLaunches(set_up.tools.context, {})
        .over_items(kernel, count, seconds_per_vertex, [&](cl_uint begin, cl_uint end) {
            set_arguments(kernel, 0, face_lattice(lattice.view), cl_double{lattice.scale_y}, cl_double{lattice.scale_z},
                          begin, end, **faces.positions, *vertices);
        });
    return vertices;
}

/// The triangles of the surface, with numbers of vertices as in the topology.
device::BufferPool::Lease triangles_of(const DeviceSetUp& set_up, const SignSurface& surface,
                                       const MeshTopology& topology) {
    const std::size_t count = topology.order.size();
    device::HostFilling filling(set_up.tools.context, set_up.tools.pool, count * sizeof(Triangle), "triangles");
    auto* const triangles = static_cast<Triangle*>(filling.memory());
    const SignSurface uses{{}, surface.faces};
    for_each_index(count, [&](std::size_t face) {
        triangles[face] = uses.triangle(topology.faces.triangles[face], topology.order[face]);
    });
    return filling.finish();
}

/// Throws if a corner is beyond the sweep's integers: but then a vertex of the mesh is.
std::shared_ptr<const LatticeBoundary> boundary_on(const SweepLattice& lattice, const std::string& mesh_name,
                                                   const OpenBoundary* boundary) {
    if (boundary == nullptr || boundary->empty()) return nullptr;
    auto result = std::make_shared<LatticeBoundary>();
    result->corners.resize(boundary->corners.size());
    result->begins = boundary->begins;
    result->bits_y = lattice.bits_y;
    result->bits_z = lattice.bits_z;
    result->first_x = lattice.first_x;
    result->spacing = lattice.view.spacing_in_units;
    const std::size_t none = boundary->corners.size();
    LeastIndex far(none);
    for_each_index(none, [&](std::size_t i) {
        SweepVertex vertex;
        if (!lattice.snap(boundary->corners[i], vertex, &result->corners[i])) far.take(i);
    });
    if (far.get() != none) refuse_far(mesh_name, "a vertex of an open edge");
    if (boundary->floor) result->floor = lattice.snapped_floor(*boundary->floor);
    return result;
}

}  // namespace

SweepSelection select_triangles(const device::Context& context, const NearRecords& near) {
    std::vector<cl_uint> numbers;
    numbers.reserve(near.face_count + 1);
    for (const RecordRange& range : near.faces)
        for (std::size_t face = range.begin; face < range.end; ++face) numbers.push_back(static_cast<cl_uint>(face));
    SweepSelection selection;
    selection.count = numbers.size();
    if (numbers.empty()) numbers.push_back(0);
    selection.triangles = device::copied(context, numbers);
    return selection;
}

const cl::Buffer& SweepMesh::triangles() const {
    return faces ? *faces->triangles : *own_triangles;
}

SweepMesh make_sweep_mesh(const DeviceSetUp& set_up, const Grid& grid, const LatticeView& view, HomedMesh& mesh,
                          const SignSurface& surface, const OpenBoundary* boundary, const DeviceFaces* faces) {
    return device::guarded([&] {
        const SweepLattice lattice(grid, view, mesh.box());
        SweepMesh result;
        if (surface.faces.empty())
            result.faces = mesh.names();
        else
            result.own_triangles = triangles_of(set_up, surface, mesh.topology());
        result.vertices =
            faces != nullptr && surface.vertices.empty() && is_within_sweep(mesh.box(), grid, view)
                ? vertices_on_device(set_up, lattice, *faces)
                : sweep_vertices(set_up, lattice, mesh.present(), surface, mesh.topology().faces.vertices);
        result.triangle_count = mesh.face_count();
        result.bits_y = lattice.bits_y;
        result.bits_z = lattice.bits_z;
        result.first_x = lattice.first_x;
        result.boundary = boundary_on(lattice, mesh.name(), boundary);
        return result;
    });
}

bool is_within_sweep(const Box& box, const Grid& grid, const LatticeView& view) {
    const SweepLattice lattice(grid, view, box);
    SweepVertex any;
    return lattice.snap(box.lower, any) && lattice.snap(box.upper, any);
}

SweepMesh near_sweep_mesh(const DeviceTools& tools, const Grid& grid, const LatticeView& view,
                          const PlacedVertices& mesh, const SignSurface& surface, const OpenBoundary* boundary,
                          const MeshTopology& topology, const std::vector<RecordRange>& faces) {
    return device::guarded([&] {
        const SweepLattice lattice(grid, view, mesh.box);
        std::size_t count = 0;
        for (const RecordRange& range : faces) count += range.end - range.begin;
        // Each face has vertices of its own.
        device::HostFilling triangle_filling(tools.context, tools.pool, count * sizeof(Triangle), "triangles");
        device::HostFilling vertex_filling(tools.context, tools.pool, 3 * count * sizeof(SweepVertex),
                                           vertices_purpose);
        auto* const triangles = static_cast<Triangle*>(triangle_filling.memory());
        auto* const vertices = static_cast<SweepVertex*>(vertex_filling.memory());
        std::size_t begin = 0;
        for (const RecordRange& range : faces) {
            for_each_range(range.end - range.begin, [&](std::size_t from, std::size_t to) {
                for (std::size_t i = from; i < to; ++i) {
                    const std::size_t face = range.begin + i;
                    Triangle swept = topology.faces.triangles[face];
                    for (std::uint32_t& vertex : swept) vertex = topology.faces.vertices[vertex];
                    if (!surface.is_mesh()) swept = surface.triangle(swept, topology.order[face]);
                    for (std::size_t k = 0; k < 3; ++k) {
                        const std::size_t n = 3 * (begin + i) + k;
                        lattice.snap(mesh.positions[swept[k]], vertices[n]);
                        triangles[begin + i][k] = static_cast<std::uint32_t>(n);
                    }
                }
            });
            begin += range.end - range.begin;
        }
        return SweepMesh{.own_triangles = triangle_filling.finish(),
                         .vertices = vertex_filling.finish(),
                         .triangle_count = count,
                         .bits_y = lattice.bits_y,
                         .bits_z = lattice.bits_z,
                         .first_x = lattice.first_x,
                         .boundary = boundary_on(lattice, mesh.name, boundary)};
    });
}

SweepMesh near_sweep_mesh(const DeviceSetUp& set_up, const Grid& grid, const LatticeView& view, const Box& box,
                          const DeviceFaces& faces, const NearRecords& near) {
    return device::guarded([&] {
        const SweepLattice lattice(grid, view, box);
        std::vector<cl_uint> numbers;
        for (const RecordRange& range : near.faces)
            for (std::size_t face = range.begin; face < range.end; face += ClusterIndex::cluster)
                numbers.push_back(static_cast<cl_uint>(face / ClusterIndex::cluster));
        const std::size_t corners = 3 * near.face_count;
        SweepMesh result{
            .own_triangles = set_up.tools.pool->lease(std::max<std::size_t>(corners, 1) * sizeof(cl_uint), "triangles"),
            .vertices =
                set_up.tools.pool->lease(std::max<std::size_t>(corners, 1) * sizeof(SweepVertex), vertices_purpose),
            .triangle_count = near.face_count,
            .bits_y = lattice.bits_y,
            .bits_z = lattice.bits_z,
            .first_x = lattice.first_x};
        if (numbers.empty()) return result;
        const auto clusters = set_up.upload(numbers, "clusters near a grid");
        device::LentKernel kernel = set_up.tools.kernel(set_up.tools.programs.face_records, "sweep_clusters");
        ShortLaunches(set_up.tools.context, {})
            .over_items(kernel, corners, seconds_per_vertex, [&](cl_uint begin, cl_uint end) {
                set_arguments(kernel, 0, face_lattice(view), cl_double{lattice.scale_y}, cl_double{lattice.scale_z},
                              begin, end, *clusters, *faces.names->triangles, **faces.positions, *result.own_triangles,
                              *result.vertices);
            });
        return result;
    });
}

}  // namespace clsdf::engine

#include "points/point_scan.hpp"

#include "core/parallel.hpp"
#include "device/buffer_pool.hpp"
#include "launch/commands.hpp"
#include "launch/short_launches.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace clsdf::points {

namespace {

constexpr std::size_t width = CLSDF_GROUP_WIDTH;
// Fewer points do not fill the groups.
constexpr std::size_t fewest_scanned = 16384;
// Beyond, the integer origin of a group stays behind: floats are as coarse there.
constexpr double farthest_origin = 1 << 22;
// Polyhedra that one work-item marks, and of how many one bounds the distances of superblocks.
constexpr std::size_t marked_together = 4096, bound_stride = 16;
// First estimates for a core; later launches use the measured time.
constexpr double seconds_per_mark = 5e-8, seconds_per_scanned_point = 1e-6;

using Extent = Eigen::AlignedBox3d;

/// The boxes of children as kernels read them. A box is widened by the rounding of floats there.
PointGroup group_of(std::span<const Extent> children) {
    Extent all;
    for (const Extent& child : children) all.extend(child);
    PointGroup group{};
    group.children = static_cast<clsdf_uint32>(children.size());
    for (int axis = 0; axis < 3; ++axis) {
        const double origin = std::round(std::clamp(all.center()[axis], -farthest_origin, farthest_origin));
        group.origin[axis] = static_cast<clsdf_int32>(origin);
        for (std::size_t i = 0; i < children.size(); ++i) {
            group.centre[axis][i] = static_cast<float>(children[i].center()[axis] - origin);
            group.half_side[axis][i] = static_cast<float>(children[i].sizes()[axis] / 2);
        }
    }
    return group;
}

/// The groups of one level, and their own boxes.
struct Level {
    UninitializedVector<PointGroup> groups;
    std::vector<Extent> extents;
};

/// extent(i): of child i.
template <typename ExtentOf>
Level level_of(std::size_t children, const ExtentOf& extent_of) {
    const std::size_t count = chunk_count(children, width);
    Level level{UninitializedVector<PointGroup>(count), std::vector<Extent>(count)};
    for_each_chunk(count, 16, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::array<Extent, width> of_children;
            const std::size_t size = std::min(width, children - i * width);
            for (std::size_t k = 0; k < size; ++k) {
                of_children[k] = extent_of(i * width + k);
                level.extents[i].extend(of_children[k]);
            }
            level.groups[i] = group_of(std::span(of_children).first(size));
        }
    });
    return level;
}

FaceNeighbours neighbours_of(const engine::MeshTopology& topology, std::size_t face) {
    FaceNeighbours neighbours{};
    const engine::FaceEdges& edges = topology.edges.faces[face];
    for (std::size_t k = 0; k < 3; ++k) {
        neighbours.vertex[k] = topology.faces.triangles[face][k];
        const std::uint8_t marks = edges.marks[k];
        const bool is_alone = (marks & engine::edge_open) != 0;
        // An edge from a vertex to itself has that vertex' faces.
        const bool are_many = (marks & (engine::edge_non_manifold | engine::edge_at_box)) != 0;
        neighbours.across[k] = are_many   ? CLSDF_MANY_ACROSS
                               : is_alone ? CLSDF_NONE_ACROSS
                                          : Corner::unpack(edges.across[k]).face;
    }
    return neighbours;
}

}  // namespace

ScannedMesh make_scanned_mesh(const engine::DeviceTools& tools, const engine::PointMesh& point_mesh,
                              const engine::Frusta& frusta, const engine::PreparedMesh& polyhedra) {
    ScannedMesh mesh;
    const engine::MeshTopology& topology = *point_mesh.topology;
    const std::size_t faces = topology.order.size(), vertices = topology.rings.vertex_count();
    const std::size_t records = faces + frusta.sites.size();
    mesh.counts.faces = static_cast<clsdf_uint32>(faces);
    mesh.counts.records = static_cast<clsdf_uint32>(records);
    double squared = 0;
    for (std::size_t face = 0; face < faces; ++face) {
        const auto corners = point_mesh.corners(face);
        for (std::size_t k = 0; k < 3; ++k) {
            const engine::Vector side = engine::to_vector(corners[(k + 1) % 3]) - engine::to_vector(corners[k]);
            squared = std::max(squared, side.squaredNorm());
        }
    }
    mesh.counts.longest = static_cast<float>(std::sqrt(squared) / point_mesh.lattice.unit * (1 + 1e-6));
    mesh.records = tools.pool->lease(records * sizeof(ScanRecord), "records of the scan of points");
    device::guarded([&] {
        device::LentKernel pack = tools.kernel(tools.programs.point_scan, "pack_records");
        engine::launch(tools.queue(), pack, {records}, *polyhedra.polyhedra, mesh.counts,
                       static_cast<cl_uint>(polyhedra.record_count - frusta.sites.size()), *mesh.records);
        tools.context.finish();
    });
    device::HostFilling neighbours(tools.context, tools.pool, faces * sizeof(FaceNeighbours), "neighbours of faces");
    auto* const to = static_cast<FaceNeighbours*>(neighbours.memory());
    for_each_index(faces, [&](std::size_t face) { to[face] = neighbours_of(topology, face); });
    mesh.neighbours = neighbours.finish();
    std::vector<std::uint32_t> starts(vertices + 1), ring_faces, site_vertices(frusta.sites.size());
    for (std::size_t v = 0; v < vertices; ++v)
        starts[v + 1] = starts[v] + static_cast<std::uint32_t>(topology.rings.size(v));
    ring_faces.resize(starts.back());
    for_each_index(vertices, [&](std::size_t v) {
        for (std::size_t i = 0; i < topology.rings.size(v); ++i)
            ring_faces[starts[v] + i] = topology.rings.corner(v, i).face;
    });
    for (std::size_t i = 0; i < site_vertices.size(); ++i) site_vertices[i] = frusta.sites[i].vertex;
    mesh.ring_starts = device::uploaded(tools.context, tools.pool, starts, "rings of vertices");
    mesh.ring_faces = device::uploaded(tools.context, tools.pool, ring_faces, "faces of rings");
    mesh.site_vertices = device::uploaded(tools.context, tools.pool, site_vertices, "vertices of point sites");
    return mesh;
}

PointGroups group_points(std::span<const Vec3> points) {
    Level bricks = level_of(chunk_count(points.size(), width), [&](std::size_t vector) {
        Extent extent;
        for (std::size_t i = vector * width; i < std::min(points.size(), (vector + 1) * width); ++i)
            extent.extend(engine::to_vector(points[i]));
        return extent;
    });
    const auto above = [](const Level& level) {
        return level_of(level.extents.size(), [&](std::size_t i) { return level.extents[i]; });
    };
    Level blocks = above(bricks), superblocks = above(blocks);
    return {std::move(bricks.groups), std::move(blocks.groups), std::move(superblocks.groups)};
}

bool is_scan_worthwhile(const engine::Programs& programs, std::size_t points, std::size_t faces) {
    return programs.body == KernelBody::by_vector && points >= std::max(faces, fewest_scanned);
}

namespace {

/// The computation of a ScanJob.
class Scan {
public:
    explicit Scan(const ScanJob& job)
        : job_(job), queue_(job.tools.context.queue()), program_(job.tools.programs.point_scan) {
        block_count_ = job.groups.blocks.size();
        superblock_count_ = job.groups.superblocks.size();
        bricks_ = device::uploaded(job.tools.context, job.tools.pool, job.groups.bricks, "bricks of points");
        blocks_ = device::uploaded(job.tools.context, job.tools.pool, job.groups.blocks, "blocks of points");
        superblocks_ =
            device::uploaded(job.tools.context, job.tools.pool, job.groups.superblocks, "superblocks of points");
    }

    /// The polyhedra that the blocks' points are looked up in.
    void mark_blocks(const std::function<void(double)>& between) {
        const auto squares = job_.tools.pool->lease(superblock_count_ * width * sizeof(float), "bounds of points");
        const std::size_t records = job_.scanned.counts.records;
        marks_ = job_.tools.pool->lease(superblock_count_ * records * sizeof(cl_ushort), "lists of blocks of points");
        device::LentKernel bound = job_.tools.kernel(program_, "bound_blocks");
        engine::launch(queue_, bound, {superblock_count_, 1}, *superblocks_, cl_uint{0},
                       static_cast<cl_uint>(job_.scanned.counts.faces > 16 * bound_stride ? bound_stride : 1),
                       job_.scanned.counts, *job_.scanned.records, *squares);
        device::LentKernel mark = job_.tools.kernel(program_, "mark_blocks");
        const std::size_t items = superblock_count_ * chunk_count(records, marked_together);
        const auto before_each = between ? [&] { between(0); } : std::function<void()>();
        engine::ShortLaunches(job_.tools.context, before_each)
            .over(items, seconds_per_mark * marked_together, [&](std::size_t begin, std::size_t end) {
                engine::launch(queue_, mark, {end - begin, 1}, *superblocks_, static_cast<cl_uint>(begin),
                               static_cast<cl_uint>(marked_together), job_.scanned.counts, *job_.scanned.records,
                               **job_.mesh.polyhedra, static_cast<cl_float>(std::sqrt(job_.most) * (1 + 1e-6)),
                               *squares, *marks_);
            });
    }

    void find_nearest(const cl::Buffer& faces, const cl::Buffer& squared, const std::function<void(double)>& between) {
        const std::size_t items = std::min<std::size_t>(job_.tools.context.capabilities().compute_units, block_count_),
                          records = job_.scanned.counts.records;
        const auto lists =
            job_.tools.pool->lease(items * 2 * (records + 1) * sizeof(cl_uint), "lists of polyhedra near points");
        const auto marks = job_.tools.pool->lease(items * records * sizeof(cl_ushort), "lists of bricks of points");
        const auto memory = job_.tools.pool->lease(items * sizeof(PointBrick), "bricks of points in work");
        const auto next_block = job_.tools.pool->lease(sizeof(cl_uint), "next block");
        device::LentKernel kernel = job_.tools.kernel(program_, "nearest_by_groups");
        engine::measured_launches(
            job_.tools.context, block_count_, seconds_per_scanned_point * CLSDF_POINTS_OF_BLOCK, items, between,
            [&](std::size_t begin, std::size_t end) {
                queue_.enqueueFillBuffer(*next_block, cl_uint{0}, 0, sizeof(cl_uint));
                engine::launch(queue_, kernel, {items, 1}, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                               *next_block, *blocks_, *bricks_, job_.points, static_cast<cl_uint>(job_.count),
                               cl_double{job_.most}, job_.scanned.counts, *job_.scanned.records, **job_.mesh.polyhedra,
                               **job_.mesh.faces, *job_.scanned.neighbours, *job_.scanned.ring_starts,
                               *job_.scanned.ring_faces, *job_.scanned.site_vertices, *marks_, *lists, *marks, *memory,
                               faces, squared);
            });
    }

private:
    const ScanJob& job_;
    cl::CommandQueue queue_;
    cl::Program program_;
    std::size_t block_count_ = 0, superblock_count_ = 0;
    device::BufferPool::Lease bricks_, blocks_, superblocks_;
    device::BufferPool::Lease marks_;
};

}  // namespace

void scan_points(const ScanJob& job, const cl::Buffer& faces, const cl::Buffer& squared,
                 const std::function<void(double)>& between) {
    Scan scan(job);
    scan.mark_blocks(between);
    scan.find_nearest(faces, squared, between);
}

}  // namespace clsdf::points

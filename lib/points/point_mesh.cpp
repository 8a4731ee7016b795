#include "points/point_mesh.hpp"

#include "core/parallel.hpp"
#include "device/host_filling.hpp"
#include "polyhedra/frame_batch.hpp"
#include "polyhedra/records.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace clsdf::points {

namespace {

constexpr std::size_t width = CLSDF_TREE_WIDTH;

// Distances to a face are off by less, in units: its frame has roundings of the size of the mesh's box.
constexpr double frame_error = 1e-6;

float rounded_down(double x) {
    return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float rounded_up(double x) {
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

/// Holds nothing: at every distance from every point.
PointNode empty_node() {
    PointNode node;
    std::fill(&node.lower[0][0], &node.lower[0][0] + 3 * width, std::numeric_limits<float>::max());
    std::fill(&node.upper[0][0], &node.upper[0][0] + 3 * width, -std::numeric_limits<float>::max());
    return node;
}

void add(PointNode& node, std::size_t child, std::size_t axis, float lower, float upper) {
    node.lower[axis][child] = std::min(node.lower[axis][child], lower);
    node.upper[axis][child] = std::max(node.upper[axis][child], upper);
}

/// The box of all children.
void add_children(const PointNode& node, PointNode& parent, std::size_t child) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        add(parent, child, axis, *std::min_element(node.lower[axis], node.lower[axis] + width),
            *std::max_element(node.upper[axis], node.upper[axis] + width));
}

PointTree shape_of(std::size_t leaves) {
    PointTree tree{};
    tree.leaves = static_cast<clsdf_uint32>(leaves);
    clsdf_uint32 first = 0;
    for (std::size_t below = leaves; tree.levels == 0 || below > 1;) {
        below = stretch_count(below, width);
        tree.first[tree.levels] = first;
        tree.count[tree.levels] = static_cast<clsdf_uint32>(below);
        first += tree.count[tree.levels++];
    }
    return tree;
}

void set_frame(const Polyhedron& record, PointLeaf& leaf, std::size_t lane) {
    const std::array<const double*, 3> gradients{record.exact_gradient_x, record.exact_gradient_y,
                                                 record.exact_gradient_z};
    const std::array<double, 3> origin{static_cast<double>(record.origin_x), static_cast<double>(record.origin_y),
                                       static_cast<double>(record.origin_z)};
    for (std::size_t column = 0; column < 3; ++column) {
        double constant = record.exact_constant_at_origin[column];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            leaf.gradient[axis][column][lane] = gradients[axis][column];
            constant -= gradients[axis][column] * origin[axis];
        }
        leaf.offset[column][lane] = constant;
    }
    for (std::size_t half = 0; half < 2; ++half) {
        leaf.base[half][lane] = record.exact_base[half];
        leaf.normal_along[half][lane] = record.exact_normal_along[half];
        leaf.normal_across[half][lane] = record.exact_normal_across[half];
    }
    leaf.altitude[lane] = record.exact_altitude;
    leaf.triangle[lane] = record.triangle;
}

/// Writes the leaves, their boxes in the nodes above them, and the records.
class LeafWriter {
public:
    LeafWriter(PointMesh& mesh, std::span<PointLeaf> leaves, std::span<Polyhedron> records)
        : mesh_(mesh), leaves_(leaves), records_(records) {}

    void write(std::size_t leaf) const {
        const polyhedra::MeshTopology& topology = *mesh_.topology;
        const std::size_t begin = leaf * width, count = std::min(width, mesh_.face_count() - begin);
        std::array<polyhedra::TriangleFrame, width> frames;
        const std::span<const Triangle> triangles(topology.faces.triangles);
        polyhedra::triangle_frames(mesh_.positions, triangles.subspan(begin, count), mesh_.lattice,
                                   std::span(frames).first(count));
        for (std::size_t i = 0; i < count; ++i)
            records_[begin + i] = polyhedra::pack(frames[i], {}, topology.order[begin + i], mesh_.positions,
                                                  triangles[begin + i], mesh_.lattice);
        for (std::size_t lane = 0; lane < width; ++lane)
            set_frame(records_[begin + std::min(lane, count - 1)], leaves_[leaf], lane);
        for (std::size_t i = 0; i < count; ++i)
            for (const Vec3& corner : mesh_.corners(begin + i)) add_corner(leaf, corner);
    }

private:
    void add_corner(std::size_t leaf, const Vec3& corner) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double at = (corner[axis] - mesh_.lattice.origin[axis]) / mesh_.lattice.unit;
            add(mesh_.nodes[leaf / width], leaf % width, axis, rounded_down(at - frame_error),
                rounded_up(at + frame_error));
        }
    }

    PointMesh& mesh_;
    std::span<PointLeaf> leaves_;
    std::span<Polyhedron> records_;
};

void fill_upper_levels(PointMesh& mesh) {
    const PointTree& tree = mesh.tree;
    for (std::size_t level = 1; level < tree.levels; ++level)
        for (std::size_t child = 0; child < tree.count[level - 1]; ++child)
            add_children(mesh.nodes[tree.first[level - 1] + child], mesh.nodes[tree.first[level] + child / width],
                         child % width);
}

}  // namespace

polyhedra::LatticeView lattice_for_points(const Mesh& mesh) {
    const double longest = mesh.box().longest_side();
    polyhedra::LatticeView lattice;
    lattice.origin = mesh.box().lower;
    if (longest > 0) lattice.unit = std::ldexp(1.0, std::max(std::ilogb(longest) - 8, -1000));
    constexpr double smallest = std::numeric_limits<float>::min(), largest = std::numeric_limits<float>::max();
    if (!(lattice.unit >= smallest && lattice.unit <= largest / 512))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the longest side of {}, {}, is beyond the floats that distances are given in; scale "
                                "the mesh",
                                mesh.name(), longest));
    return lattice;
}

UnitBox::UnitBox(const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto nearest = static_cast<float>(p[axis]);
        lower[axis] = std::nextafter(nearest, -std::numeric_limits<float>::infinity());
        upper[axis] = std::nextafter(nearest, std::numeric_limits<float>::infinity());
    }
}

void UnitBox::add(const UnitBox& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = std::min(lower[axis], other.lower[axis]);
        upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
}

UnitBox leaf_box(const PointMesh& mesh, std::size_t leaf) {
    UnitBox box;
    const PointNode& node = mesh.nodes[leaf / width];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = node.lower[axis][leaf % width];
        box.upper[axis] = node.upper[axis][leaf % width];
    }
    return box;
}

PointMesh make_point_mesh(device::Context& context, const std::shared_ptr<device::BufferPool>& pool, const Mesh& mesh,
                          std::shared_ptr<const polyhedra::MeshTopology> topology) {
    PointMesh result;
    result.lattice = lattice_for_points(mesh);
    result.box = mesh.box();
    result.topology = std::move(topology);
    const UninitializedVector<std::uint32_t>& vertices = result.topology->faces.vertices;
    result.positions.resize(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t i) { result.positions[i] = mesh.vertices()[vertices[i]]; });

    const std::size_t leaf_count = stretch_count(result.face_count(), width);
    result.tree = shape_of(leaf_count);
    result.nodes.assign(result.tree.first[result.tree.levels - 1] + 1, empty_node());
    device::HostFilling leaves(context, pool, leaf_count * sizeof(PointLeaf), "leaves of the points' tree");
    device::HostFilling records(context, pool, result.face_count() * sizeof(Polyhedron), "polyhedra");
    const LeafWriter writer(result, {static_cast<PointLeaf*>(leaves.memory()), leaf_count},
                            {static_cast<Polyhedron*>(records.memory()), result.face_count()});
    // Leaves of a node are written by one thread.
    for_each_stretch(leaf_count, width, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t leaf = begin; leaf < end; ++leaf) writer.write(leaf);
    });
    fill_upper_levels(result);
    result.leaves = leaves.finish();
    result.polyhedra = records.finish();
    const std::size_t bytes = result.nodes.size() * sizeof(PointNode);
    result.device_nodes = pool->lease(bytes, "nodes of the points' tree");
    device::guarded(
        [&] { context.queue().enqueueWriteBuffer(*result.device_nodes, CL_TRUE, 0, bytes, result.nodes.data()); });
    return result;
}

}  // namespace clsdf::points

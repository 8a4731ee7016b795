#include "tree/wide_tree.hpp"

#include "core/parallel.hpp"
#include "launch/programs.hpp"
#include "tree/one_lane.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace clsdf::engine {

namespace {

constexpr std::size_t width = CLSDF_TREE_WIDTH;

// Distances to a face are off by less, in units: its frame has roundings of the size of the mesh's box.
constexpr double frame_error = 1e-6;
// In units. Boxes are clamped to it, so that squared distances are finite in floats: infinity marks a child that does
// not exist. Boxes nearer to the mesh do not change.
constexpr double box_limit = 1e18;

float rounded_down(double x) {
    return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float rounded_up(double x) {
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

/// Holds nothing, infinitely far from every point.
PointNode empty_node() {
    PointNode node;
    std::fill(&node.lower[0][0], &node.lower[0][0] + 3 * width, std::numeric_limits<float>::infinity());
    std::fill(&node.upper[0][0], &node.upper[0][0] + 3 * width, -std::numeric_limits<float>::infinity());
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

PointTree shape_of(std::size_t faces) {
    PointTree tree{};
    tree.faces = static_cast<clsdf_uint32>(faces);
    clsdf_uint32 first = 0;
    for (std::size_t below = faces; tree.levels == 0 || below > 1;) {
        below = chunk_count(below, width);
        tree.first[tree.levels] = first;
        tree.count[tree.levels] = static_cast<clsdf_uint32>(below);
        first += tree.count[tree.levels++];
    }
    return tree;
}

/// Fills the nodes of the first level with the boxes of their faces.
void fill_first_level(const PointMesh& mesh, WideTree& tree) {
    for_each_chunk(tree.shape.count[0], width, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t face = begin * width; face < std::min(end * width, mesh.face_count()); ++face)
            for (const Vec3& corner : mesh.corners(face)) {
                const Vec3 at = mesh.in_units(corner);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    add(tree.nodes[face / width], face % width, axis, rounded_down(at[axis] - frame_error),
                        rounded_up(at[axis] + frame_error));
            }
    });
}

void fill_upper_levels(WideTree& tree) {
    const PointTree& shape = tree.shape;
    for (std::size_t level = 1; level < shape.levels; ++level)
        for (std::size_t child = 0; child < shape.count[level - 1]; ++child)
            add_children(tree.nodes[shape.first[level - 1] + child], tree.nodes[shape.first[level] + child / width],
                         child % width);
}

/// Frames of neighbours, at most as many as a leaf holds, from the centre of their node's boxes.
PointLeaf leaf_of(const PointNode& node, std::span<const Polyhedron> records, std::span<const PointFace> faces) {
    PointLeaf leaf{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        leaf.origin[axis] = (*std::min_element(node.lower[axis], node.lower[axis] + faces.size()) +
                             *std::max_element(node.upper[axis], node.upper[axis] + faces.size())) /
                            2;
    double extent = 0;
    for (std::size_t lane = 0; lane < width; ++lane) {
        const std::size_t face = std::min(lane, faces.size() - 1);
        const Polyhedron& record = records[face];
        const std::array<const double*, 3> gradients{record.exact_gradient_x, record.exact_gradient_y,
                                                     record.exact_gradient_z};
        double lengths = record.exact_base[0] + record.exact_base[1] + record.exact_altitude;
        for (std::size_t column = 0; column < 3; ++column) {
            double offset = faces[face].offset[column];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                leaf.gradient[axis][column][lane] = static_cast<float>(gradients[axis][column]);
                offset += gradients[axis][column] * static_cast<double>(leaf.origin[axis]);
            }
            leaf.offset[column][lane] = static_cast<float>(offset);
            lengths += std::abs(offset);
        }
        for (std::size_t half = 0; half < 2; ++half) {
            leaf.base[half][lane] = static_cast<float>(record.exact_base[half]);
            leaf.normal_along[half][lane] = static_cast<float>(record.exact_normal_along[half]);
            leaf.normal_across[half][lane] = static_cast<float>(record.exact_normal_across[half]);
        }
        leaf.altitude[lane] = static_cast<float>(record.exact_altitude);
        extent = std::max(extent, lengths);
    }
    leaf.extent = rounded_up(extent);
    return leaf;
}

}  // namespace

UnitBox::UnitBox(const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = rounded_down(p[axis]);
        upper[axis] = rounded_up(p[axis]);
    }
}

UnitBox::UnitBox(const Box& box, const LatticeView& lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto in_units = [&](double x) {
            return std::clamp((x - lattice.origin[axis]) / lattice.unit, -box_limit, box_limit);
        };
        lower[axis] = rounded_down(in_units(box.lower[axis]));
        upper[axis] = rounded_up(in_units(box.upper[axis]));
    }
}

void UnitBox::add(const UnitBox& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = std::min(lower[axis], other.lower[axis]);
        upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
}

std::uint32_t overlapped_children(const PointNode& node, const UnitBox& box) {
    return one_lane::overlapped_children(&node, box);
}

UnitBox face_box(const WideTree& tree, std::size_t face) {
    UnitBox box;
    const PointNode& node = tree.nodes[face / width];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = node.lower[axis][face % width];
        box.upper[axis] = node.upper[axis][face % width];
    }
    return box;
}

WideTree make_wide_tree(const PointMesh& mesh) {
    WideTree tree;
    tree.shape = shape_of(mesh.face_count());
    tree.nodes = UninitializedVector<PointNode>(std::size_t{tree.shape.first[tree.shape.levels - 1]} + 1, empty_node());
    fill_first_level(mesh, tree);
    fill_upper_levels(tree);
    return tree;
}

WideLeaves make_wide_leaves(const DeviceTools& tools, const PointMesh& mesh, std::shared_ptr<const WideTree> tree) {
    WideLeaves result;
    result.tree = std::move(tree);
    const std::span<const PointNode> nodes = result.tree->nodes;
    const std::size_t count = result.tree->shape.count[0];
    const auto write = [&](PointLeaf* leaves) {
        const std::span records(static_cast<const Polyhedron*>(mesh.polyhedra->on_host()), mesh.face_count());
        const std::span faces(static_cast<const PointFace*>(mesh.faces->on_host()), mesh.face_count());
        for_each_chunk(count, width, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t leaf = begin; leaf < end; ++leaf) {
                const std::size_t first = leaf * width, size = std::min(width, mesh.face_count() - first);
                leaves[leaf] = leaf_of(nodes[leaf], records.subspan(first, size), faces.subspan(first, size));
            }
        });
    };
    if (tools.programs.body == KernelBody::by_group) {
        result.leaves.resize(count);
        write(result.leaves.data());
        return result;
    }
    device::HostFilling filling(tools.context, tools.pool, count * sizeof(PointLeaf), "leaves of the points' tree");
    write(static_cast<PointLeaf*>(filling.memory()));
    result.device_leaves = filling.finish();
    result.device_nodes =
        device::uploaded(tools.context, tools.pool, nodes.subspan(count), "nodes of the points' tree");
    return result;
}

}  // namespace clsdf::engine

#pragma once

#include "core/kept_array.hpp"
#include "core/kernel_language.hpp"
#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "tree/point_mesh.hpp"

#include "point_tree.h"
#include "tree_walk.h"

#include <clsdf/mesh.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

/// The tree of 16 children a node in which processors and the host look for faces (kernels/tree/point_tree.h).
namespace clsdf::engine {

/// The boxes of the faces of a PointMesh, and of what is above them, for the host.
struct WideTree {
    PointTree shape{};
    KeptArray<PointNode> nodes;  ///< by levels; the children of the first level are faces; the root is the last

    std::size_t host_bytes() const { return nodes.host_bytes(); }
};

/// What a search for the nearest face reads beside the mesh: for the body by_vector in buffers, which the host reads,
/// too; for the body by_group, whose kernels have another tree, in the host's memory alone.
struct WideLeaves {
    std::shared_ptr<const WideTree> tree;
    device::BufferPool::Lease device_nodes;   ///< those of the tree from the second level on
    device::BufferPool::Lease device_leaves;  ///< PointLeaf, in place of the first level
    KeptArray<PointLeaf> leaves;              ///< if they are in no buffer

    const PointLeaf* on_host() const {
        return leaves.empty() ? static_cast<const PointLeaf*>(device_leaves.on_host()) : leaves.data();
    }
    std::size_t host_bytes() const { return leaves.host_bytes(); }
    std::size_t device_bytes() const { return device_nodes.bytes() + device_leaves.bytes(); }
};

/// Throws std::bad_alloc.
WideTree make_wide_tree(const PointMesh& mesh);

/// tree: of the same mesh, whose faces the host reads. Throws Error(device_failure or out_of_memory).
WideLeaves make_wide_leaves(const DeviceTools& tools, const PointMesh& mesh, std::shared_ptr<const WideTree> tree);

/// A mesh and the tree in which the host finds its faces.
struct SearchedMesh {
    const PointMesh& mesh;
    const WideTree& tree;
};

/// A box in units, closed.
struct UnitBox : PointBox {
    UnitBox() : PointBox{} {}
    /// The smallest one around a point.
    explicit UnitBox(const Vec3& p);
    /// Around a box in the caller's coordinates, rounded outwards and cut off far from the mesh.
    UnitBox(const Box& box, const LatticeView& lattice);

    void add(const UnitBox& other);
};

/// Around a face, with room for the rounding of frames.
UnitBox face_box(const WideTree& tree, std::size_t face);

/// Bits of the children whose boxes overlap the given one.
std::uint32_t overlapped_children(const PointNode& node, const UnitBox& box);

/// The walk of tree_walk.h, compiled by the host, down to faces.
namespace wide_walk {

using namespace kernel_language;

inline uint lowest_bit(uint bits) {
    return static_cast<uint>(std::countr_zero(bits));
}

template <typename Choose, typename Next, typename Visit>
struct Query {
    const WideTree& tree;
    const Choose& choose;
    const Next& next;
    const Visit& visit;

    /// The faces of a node of the first level.
    bool visit_leaf(uint leaf) const {
        for (uint bits = choose(tree.nodes[leaf], 1U); bits != 0;) {
            const uint child = next(bits, 1U);
            if (child == CLSDF_NO_CHILD) break;
            bits &= ~(1U << child);
            if (visit(std::size_t{leaf} * CLSDF_TREE_WIDTH + child)) return true;
        }
        return false;
    }
};

#define __global
#define __private
#define CLSDF_CHOSEN(node, level, query) (query)->choose(*(node), level)
#define CLSDF_NEXT(bits, level, query) (query)->next(bits, level)
#define CLSDF_VISITED(leaf, query) (query)->visit_leaf(leaf)
template <typename Query>
DEFINE_WIDE_WALK(walk, Query, CLSDF_CHOSEN, CLSDF_NEXT, CLSDF_VISITED)
#undef CLSDF_CHOSEN
#undef CLSDF_NEXT
#undef CLSDF_VISITED
#undef __global
#undef __private

}  // namespace wide_walk

/// Goes down the tree from the root. choose(node, level) returns bits of the children that may be visited; those of the
/// first level are faces. next(bits, level) returns the child to visit next of those that are left, or CLSDF_NO_CHILD.
/// Calls visit(face) for these faces until it returns true. Returns whether it did.
template <typename Choose, typename Next, typename Visit>
bool traverse(const WideTree& tree, const Choose& choose, const Next& next, const Visit& visit) {
    wide_walk::Query<Choose, Next, Visit> query{tree, choose, next, visit};
    return wide_walk::walk(tree.shape, tree.nodes.data() + tree.shape.count[0], &query);
}

/// Calls visit(face) for all faces whose boxes overlap the given one, ascending, until it returns true. Returns whether
/// it did.
template <typename Visit>
bool visit_faces(const WideTree& tree, const UnitBox& box, const Visit& visit) {
    return traverse(
        tree, [&](const PointNode& node, std::uint32_t) { return overlapped_children(node, box); },
        [](std::uint32_t bits, std::uint32_t) { return wide_walk::lowest_bit(bits); }, visit);
}

}  // namespace clsdf::engine

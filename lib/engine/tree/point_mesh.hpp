#pragma once

#include "core/large_memory.hpp"
#include "device/buffer_pool.hpp"
#include "frusta/frames.hpp"
#include "frusta/topology.hpp"
#include "launch/device_tools.hpp"
#include "mesh/film_tree.hpp"
#include "mesh/sign_surface.hpp"

#include "point_tree.h"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::engine {

/// The lattice that points are measured in: its origin is the lower corner of the mesh's box, its unit the greatest
/// power of two not above 1/256 of the box's longest side, or 1 if the mesh has no extent. Throws
/// Error(invalid_argument) if a float cannot hold the unit.
LatticeView lattice_for_points(const Mesh& mesh);

/// Whether a closed box contains the point.
inline bool contains(const Box& box, const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (p[axis] < box.lower[axis] || p[axis] > box.upper[axis]) return false;
    return true;
}

/// A mesh as searches for the nearest triangle of a point read it, on the device and, for signs, on the host. It
/// follows from the triangles and the positions alone.
struct PointMesh {
    LatticeView lattice;
    Box box;                           ///< of the mesh
    bool is_part = false;              ///< faces that cross rows with greater x than those of the points may be missing
    bool has_several_regions = false;  ///< a part: between points of two regions, any face may be missing
    std::shared_ptr<const MeshTopology> topology;  ///< whose faces the tree's faces are
    UninitializedVector<Vec3> positions;           ///< of the vertices, numbered as in MeshTopology::faces
    std::vector<Vec3> sign_positions;              ///< those that decide the sign; empty: the same
    std::vector<std::int8_t> sign_counts;          ///< how often each face counts for the sign; empty: once
    std::shared_ptr<const FilmTree> film;          ///< of the open edges; null if none count
    std::vector<bool> is_joined;                   ///< of each vertex, whether it is with another one; empty: none
    PointTree tree{};
    std::vector<PointNode> nodes;  ///< by levels; the children of the first level are faces; the root is the last

    device::BufferPool::Lease device_nodes;  ///< the same, from the second level on
    device::BufferPool::Lease leaves;        ///< PointLeaf, in place of the first level
    device::BufferPool::Lease polyhedra;     ///< Polyhedron, of each face, with frames and without slopes
    device::BufferPool::Lease faces;         ///< PointFace of each face

    /// A position from the lattice's origin.
    Vec3 in_units(const Vec3& position) const {
        Vec3 result{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            result[axis] = (position[axis] - lattice.origin[axis]) / lattice.unit;
        return result;
    }

    std::size_t face_count() const { return topology->order.size(); }
    std::array<Vec3, 3> corners(std::size_t face) const {
        const auto& [a, b, c] = topology->faces.triangles[face];
        return {positions[a], positions[b], positions[c]};
    }

    /// The corners that decide the sign, in the order as given: within joined_extent of the mesh's side of the others.
    std::array<Vec3, 3> sign_corners(std::size_t face) const {
        if (sign_positions.empty()) return corners(face);
        const auto& [a, b, c] = topology->faces.triangles[face];
        return {sign_positions[a], sign_positions[b], sign_positions[c]};
    }
    /// How often the face counts for the sign: 1, 0, or -1 if it is turned around.
    int sign_count(std::size_t face) const { return sign_counts.empty() ? 1 : sign_counts[face]; }
    /// Whether a face has a vertex that is joined with another one, and its corners may be others for the sign.
    bool has_joined_vertex(std::size_t face) const {
        return !is_joined.empty() && std::ranges::any_of(topology->faces.triangles[face],
                                                         [&](std::uint32_t vertex) { return is_joined[vertex]; });
    }

    std::size_t host_bytes() const {
        return (positions.size() + sign_positions.size()) * sizeof(Vec3) + sign_counts.size() + is_joined.size() / 8 +
               nodes.size() * sizeof(PointNode) + (film ? film->host_bytes() : 0);
    }
    std::size_t device_bytes() const {
        return device_nodes.bytes() + leaves.bytes() + polyhedra.bytes() + faces.bytes();
    }
};

/// A box in units, closed.
struct UnitBox {
    std::array<float, 3> lower{}, upper{};

    UnitBox() = default;
    /// The smallest one around a point.
    explicit UnitBox(const Vec3& p);
    /// Around a box in the caller's coordinates, rounded outwards and cut off far from the mesh.
    UnitBox(const Box& box, const LatticeView& lattice);

    void add(const UnitBox& other);
};

/// Around a face, with room for the rounding of frames.
UnitBox face_box(const PointMesh& mesh, std::size_t face);

/// Children of a node to visit: a bit for each, and the one to begin with.
struct ChosenChildren {
    std::uint32_t bits;
    std::uint32_t first;
};

/// The children whose boxes overlap the given one, ascending.
ChosenChildren overlapped_children(const PointNode& node, const UnitBox& box);

/// Goes down the tree from the root, or from a node of a level: choose(node) returns its ChosenChildren. Calls
/// visit(face) for chosen faces until it returns true. Returns whether it did.
template <typename Choose, typename Visit>
bool traverse(const PointMesh& mesh, const Choose& choose, const Visit& visit, std::size_t level,
              std::size_t number = 0) {
    auto [bits, next] = choose(mesh.nodes[mesh.tree.first[level] + number]);
    for (; bits != 0; next = static_cast<std::uint32_t>(std::countr_zero(bits))) {
        bits &= ~(1U << next);
        const std::size_t child = number * CLSDF_TREE_WIDTH + next;
        if (level > 0 ? traverse(mesh, choose, visit, level - 1, child) : visit(child)) return true;
    }
    return false;
}
template <typename Choose, typename Visit>
bool traverse(const PointMesh& mesh, const Choose& choose, const Visit& visit) {
    return traverse(mesh, choose, visit, mesh.tree.levels - 1);
}

/// Calls visit(face) for all faces whose boxes overlap the given one, ascending, until it returns true. Returns whether
/// it did.
template <typename Visit>
bool visit_faces(const PointMesh& mesh, const UnitBox& box, const Visit& visit) {
    return traverse(
        mesh, [&](const PointNode& node) { return overlapped_children(node, box); }, visit);
}

/// Throws Error(invalid_argument or out_of_memory).
PointMesh make_point_mesh(const DeviceTools& tools, const Mesh& mesh, const SignSurface& surface,
                          std::shared_ptr<const MeshTopology> topology);

}  // namespace clsdf::engine

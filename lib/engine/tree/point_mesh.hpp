#pragma once

#include "core/kept_array.hpp"
#include "device/buffer_pool.hpp"
#include "frusta/frames.hpp"
#include "launch/device_tools.hpp"
#include "surface/film_tree.hpp"
#include "surface/sign_surface.hpp"
#include "surface/walls.hpp"
#include "topology/device_topology.hpp"
#include "topology/topology.hpp"

#include "point_faces.h"
#include "point_tree.h"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::engine {

/// The lattice that points are measured in: its origin is the lower corner of the mesh's box, its unit the greatest
/// power of two not above 1/256 of the box's longest side, or 1 if the mesh has no extent. Throws
/// Error(invalid_argument) if a float cannot hold the unit.
LatticeView lattice_for_points(const Box& box, const std::string& name);

/// Whether a closed box contains the point; false if a coordinate is not a number.
inline bool contains(const Box& box, const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(p[axis] >= box.lower[axis] && p[axis] <= box.upper[axis])) return false;
    return true;
}

/// A mesh whose topology and positions are on a GPU. Each edge has one face, or two of one orientation.
struct GeometryOnDevice {
    std::shared_ptr<const DeviceTopology> topology;
    std::shared_ptr<const device::BufferPool::Lease> positions;  ///< Vec3 of each vertex
};

/// The faces of a mesh as kernels read them that look points up. They follow from the triangles and the positions
/// alone. Trees find them: WideTree and FittedTree.
struct PointFaces {
    LatticeView lattice;
    Box box;                               ///< of the mesh
    std::size_t count = 0;                 ///< of the faces
    std::shared_ptr<const FilmTree> film;  ///< of the open edges; null if none count, or if walls hang there
    std::shared_ptr<const Walls> walls;    ///< of the rule `below`; else null

    /// Polyhedron, of each face, with frames and without slopes.
    std::shared_ptr<const device::BufferPool::Lease> polyhedra;
    std::shared_ptr<const device::BufferPool::Lease> faces;  ///< PointFace of each face

    /// If kernels have made the faces; then the surface that decides the sign is the mesh.
    std::optional<GeometryOnDevice> geometry;
    PointFacesFound found{};  ///< by them

    /// A position from the lattice's origin.
    Vec3 in_units(const Vec3& position) const {
        Vec3 result{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            result[axis] = (position[axis] - lattice.origin[axis]) / lattice.unit;
        return result;
    }

    /// Around all that is inside, unless there is a film.
    Box sign_box() const {
        Box result = box;
        if (walls) result.lower[2] = walls->floor();
        return result;
    }

    std::size_t host_bytes() const { return (film ? film->host_bytes() : 0) + (walls ? walls->host_bytes() : 0); }
    /// 0 without polyhedra and faces: the host alone reads it.
    std::size_t device_bytes() const { return (polyhedra ? polyhedra->bytes() : 0) + (faces ? faces->bytes() : 0); }
};

/// The same with what the host reads, for signs above all.
struct PointMesh : PointFaces {
    bool is_part = false;              ///< faces that cross rows with greater x than those of the points may be missing
    bool has_several_regions = false;  ///< a part: between points of two regions, any face may be missing
    std::shared_ptr<const MeshTopology> topology;  ///< which numbers the faces
    KeptArray<Vec3> positions;                     ///< of the vertices, numbered as in MeshTopology::faces
    KeptArray<Vec3> sign_positions;                ///< those that decide the sign; empty: the same
    KeptArray<std::int8_t> sign_counts;            ///< how often each face counts for the sign; empty: once
    std::vector<bool> is_joined;                   ///< of each vertex, whether it is with another one; empty: none

    std::size_t face_count() const { return count; }
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
        return positions.host_bytes() + sign_positions.host_bytes() + sign_counts.host_bytes() + is_joined.size() / 8 +
               PointFaces::host_bytes();
    }
};

/// What the host reads of it: without polyhedra, faces and film. Throws Error(invalid_argument).
PointMesh make_host_point_mesh(const Mesh& mesh, const SignSurface& surface,
                               std::shared_ptr<const MeshTopology> topology);
/// Without film. made: the faces if kernels have made them, or null. Throws Error(invalid_argument or out_of_memory).
PointMesh make_point_mesh(const DeviceTools& tools, const Mesh& mesh, const SignSurface& surface,
                          std::shared_ptr<const MeshTopology> topology, const PointFaces* made = nullptr);

/// The faces by kernels, with the same bytes unless the host does a special case. Does not wait. found: a
/// PointFacesFound, zeros before; the result's `found` is left to the caller. Throws Error(invalid_argument,
/// out_of_memory or device_failure).
PointFaces make_point_faces(const DeviceTools& tools, const Box& box, const std::string& name,
                            GeometryOnDevice geometry, const cl::Buffer& found);

}  // namespace clsdf::engine

#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/join_vertices.hpp"
#include "mesh/vertices.hpp"
#include "surface/open_edges.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace clsdf {

/// The surface that decides the sign (docs/sign.md): the mesh, but for vertices that differ by rounding, doubled faces
/// and faces that look the wrong way. It follows from the triangles and the first positions; it is empty, and the mesh
/// itself decides, if the mesh is balanced. Distances, slopes, sites and the lowest triangle never depend on it.
struct SignSurface {
    /// The part of a face in the surface. A face that does not count has a direction for the gradient on it.
    enum Use : std::int8_t { backward = -1, forward = 1, unused_backward = -2, unused_forward = 2 };

    std::vector<std::uint32_t> vertices;  ///< for each vertex of the mesh that whose position counts; empty: itself
    std::vector<Use> faces;               ///< by face of the mesh; empty: all are forward
    OpenLoops open_loops{};  ///< set for the rules solid_angle and below alone, if the surface is not balanced

    bool is_mesh() const { return vertices.empty() && faces.empty(); }
    std::uint32_t vertex(std::uint32_t v) const { return vertices.empty() ? v : vertices[v]; }
    /// How often the face counts: 1, 0, or -1 if it is turned around.
    int count(std::size_t face) const { return faces.empty() ? 1 : count_of(faces[face]); }
    /// -1 if the face's normal points to the back of the surface.
    int direction(std::size_t face) const { return faces.empty() || faces[face] > 0 ? 1 : -1; }

    static int count_of(Use use) { return use == forward ? 1 : use == backward ? -1 : 0; }

    /// The face with the vertices that count, turned around if it is backward; a point if it does not count.
    Triangle triangle(const Triangle& given, std::size_t face) const {
        const Triangle counting{vertex(given[0]), vertex(given[1]), vertex(given[2])};
        const int times = count(face);
        if (times > 0) return counting;
        if (times < 0) return {counting[0], counting[2], counting[1]};
        return {counting[0], counting[0], counting[0]};
    }

    std::size_t host_bytes() const { return vertices.size() * sizeof(vertices[0]) + faces.size() * sizeof(faces[0]); }
};

/// Vertices nearer to each other than that part of the longest side are joined.
inline constexpr double joining_tolerance = 0x1p-43;
/// Joined vertices are never farther apart on an axis, as a part of the longest side.
inline constexpr double joined_extent = longest_cluster * joining_tolerance;

/// Faces with the same three vertices, and one of them.
struct DoubledFace {
    std::uint32_t face;
    std::uint32_t first;  ///< the lowest of them
    bool is_reversed;     ///< the two are oriented differently
};

/// The faces with the three different vertices of an earlier one, in the order of the groups.
std::vector<DoubledFace> doubled_faces(std::span<const Triangle> triangles, std::size_t vertex_count);

/// Throws Error(invalid_argument) that names the caller's vertices if some that are joined for the sign move farther
/// apart than joined_extent of the longest side. `moved`: as Vertices::moved() returns them.
void check_joined(const engine::Vertices& vertices, const Mesh& mesh, const SignSurface& surface,
                  std::span<const Vec3> moved);
/// The same of a part of a mesh with this name, whose box is that of the whole at the new positions. callers_number: of
/// a vertex.
void check_joined(const std::string& name, const Box& box, const SignSurface& surface, std::span<const Vec3> moved,
                  const std::function<std::size_t(std::uint32_t)>& callers_number);

}  // namespace clsdf

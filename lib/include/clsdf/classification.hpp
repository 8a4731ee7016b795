#pragma once

#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// What Peikert & Sigg (Optimized Bounding Polyhedra for GPU-Based Distance Transform) ask of a mesh, decided exactly
/// on the coordinates as given. Vertices of equal coordinates count as one, and faces with repeated vertices drop out.
namespace clsdf {

enum class EdgeKind : std::uint8_t {
    convex,
    concave,
    flat,          ///< its two faces lie in one plane
    boundary,      ///< one face
    unoriented,    ///< two faces that run along it in the same direction
    non_manifold,  ///< three faces or more
};
inline constexpr std::size_t edge_kinds = 6;

enum class VertexKind : std::uint8_t {
    convex,   ///< convex edges, and no concave one
    concave,  ///< concave edges, and no convex one
    flat,     ///< neither
    saddle,   ///< both
    boundary,
    non_manifold,  ///< an edge that is unoriented or not manifold, or several fans of faces
    unused,        ///< no face
};
inline constexpr std::size_t vertex_kinds = 7;

/// "convex", "non-manifold", ...
CLSDF_EXPORT const char* name_of(EdgeKind kind);
CLSDF_EXPORT const char* name_of(VertexKind kind);

struct Classification {
    std::vector<VertexKind> vertices;  ///< by vertex; equal ones are of one kind

    std::size_t count(EdgeKind kind) const { return edge_counts[static_cast<std::size_t>(kind)]; }
    std::size_t count(VertexKind kind) const { return vertex_counts[static_cast<std::size_t>(kind)]; }

    std::array<std::size_t, edge_kinds> edge_counts{};
    std::array<std::size_t, vertex_kinds> vertex_counts{};  ///< equal vertices count as one
};

CLSDF_EXPORT Classification classify(const Mesh& mesh);

/// What is found at the saddle vertices, the lower vertex first.
struct SaddleReport {
    /// A face is flipped when seen along the average of the incident faces' unit normals: Peikert & Sigg presuppose
    /// that none is. A face that is seen edgewise, or has no area, counts as flipped.
    std::vector<std::uint32_t> irregular;
    /// The published test fails: a line in which two successive bisector planes meet lies strictly on one side of all
    /// others.
    std::vector<std::uint32_t> adjacent_gaps;
    /// The complete test fails: there are points strictly on one side of all bisector planes. Holds for all of the
    /// former.
    std::vector<std::uint32_t> gaps;

    std::size_t saddles = 0;
    std::size_t decisions = 0;        ///< signs that were asked for
    std::size_t exact_decisions = 0;  ///< of these, the ones that interval arithmetic left open
};

/// Decided by interval arithmetic, and where that does not suffice by exact numbers with square roots: there are no
/// tolerances. Parallel planes give no test point; neither does the plane of an edge whose faces are folded onto each
/// other exactly, or one of which has no area.
CLSDF_EXPORT SaddleReport examine_saddles(const Mesh& mesh);

struct RegularMesh {
    Mesh mesh;
    std::size_t irregular_vertices = 0;  ///< saddle vertices that still are not regular
    std::size_t added_vertices = 0;
};

/// Peikert & Sigg's remedy for irregular saddle vertices: the same surface with some triangles cut in two, through the
/// middle of an edge. A face flipped at a vertex counts twice in the average of its normals after the cut, which is one
/// step of the perceptron, so that the cuts end wherever there is a direction from which no face is flipped; elsewhere
/// nothing is cut. Middles are rounded to double, so that a flat edge can become convex or concave by that much. Stops
/// after `rounds`, with at most one cut a vertex in each.
CLSDF_EXPORT RegularMesh subdivide_irregular(const Mesh& mesh, std::size_t rounds = 32);

}  // namespace clsdf

#pragma once

#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace clsdf {

/// The rule that decides which points are inside; inside is negative. The values of the enumerators never change.
enum class SignRule : std::int32_t {
    automatic = 0,  ///< balanced: nonzero; closed: parity; else unsigned (with a warning for the last two)
    nonzero = 1,    ///< inside if the winding number is not zero; needs a balanced mesh
    parity = 2,     ///< inside if a ray crosses the surface an odd number of times; needs a closed mesh
    none = 3,       ///< no sign: the distance alone
};

/// "auto", "nonzero", "parity", "none".
CLSDF_EXPORT const char* name_of(SignRule rule);

/// The properties of a mesh that the sign rule depends on. Vertices of equal coordinates count as one. Faces with
/// repeated vertices are left out; faces of zero area count.
struct Topology {
    struct Edge {
        Vec3 from;
        Vec3 to;
    };

    bool closed = false;      ///< every undirected edge has an even number of faces
    bool balanced = false;    ///< every edge is used equally often in both directions
    bool inside_out = false;  ///< balanced, and the enclosed volume is negative

    std::size_t open_edges = 0;             ///< undirected edges with an odd number of faces
    std::size_t unbalanced_edges = 0;       ///< undirected edges not used equally often in both directions
    std::size_t non_manifold_edges = 0;     ///< undirected edges with more than two faces
    std::size_t repeated_vertex_faces = 0;  ///< faces with fewer than three different vertices
    std::size_t coincident_vertices = 0;    ///< vertices in use that equal an earlier one
    std::size_t unused_vertices = 0;
    std::vector<Edge> first_open_edges;        ///< up to five, in the order of the triangles
    std::vector<Edge> first_unbalanced_edges;  ///< up to five
};

/// Throws Error(unsupported) for 2^30 triangles or more.
CLSDF_EXPORT Topology describe_topology(const Mesh& mesh);

/// The rule in use, and a warning about it, which may be empty.
struct ResolvedSignRule {
    SignRule rule = SignRule::none;  ///< never `automatic`
    std::string warning;
};

/// Throws Error(invalid_mesh) with the number of offending edges and the first of them if the mesh does not meet the
/// rule.
CLSDF_EXPORT ResolvedSignRule resolve_sign_rule(SignRule asked, const Topology& topology);

}  // namespace clsdf

#pragma once

#include <clsdf/mesh.hpp>

namespace clsdf {

/// What the sign rule needs to know about a mesh. Vertices of equal coordinates count as one, and faces with repeated
/// vertices drop out; faces of zero area stay.
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

Topology describe_topology(const Mesh& mesh);

}  // namespace clsdf

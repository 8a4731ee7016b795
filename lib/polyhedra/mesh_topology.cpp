#include "polyhedra/mesh_topology.hpp"

#include "polyhedra/morton_order.hpp"

namespace clsdf::polyhedra {

MeshTopology::MeshTopology(const Mesh& mesh)
    : order(morton_order(mesh)),
      faces(ordered_faces(mesh, order)),
      rings(faces),
      edges(pair_edges(faces.triangles, rings)) {}

std::size_t MeshTopology::bytes() const {
    return order.size() * sizeof(order[0]) + faces.triangles.size() * sizeof(Triangle) +
           faces.vertices.size() * sizeof(std::uint32_t) + rings.bytes() + edges.faces.size() * sizeof(FaceEdges);
}

}  // namespace clsdf::polyhedra

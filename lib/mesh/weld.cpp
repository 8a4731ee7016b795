#include <clsdf/mesh.hpp>

#include "mesh/equal_vertices.hpp"

#include <utility>

namespace clsdf {

Mesh weld(const Mesh& mesh) {
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> new_index(first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
        if (first[i] == i) {
            new_index[i] = static_cast<std::uint32_t>(vertices.size());
            vertices.push_back(mesh.vertices()[i]);
        } else {
            new_index[i] = new_index[first[i]];
        }
    }
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) index = new_index[index];
    return Mesh(std::move(vertices), std::move(triangles), mesh.name());
}

}  // namespace clsdf

#include <clsdf/mesh_files.hpp>

#include "mesh/equal_vertices.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <numeric>

namespace clsdf {

namespace {

/// Disjoint sets of vertices (union-find).
class Parts {
public:
    explicit Parts(std::size_t vertex_count) : parent_(vertex_count) {
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }

    std::uint32_t part_of(std::uint32_t vertex) {
        while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
        return vertex;
    }

    void join(std::uint32_t a, std::uint32_t b) { parent_[part_of(a)] = part_of(b); }

private:
    std::vector<std::uint32_t> parent_;
};

bool has_no_area(const Mesh& mesh, const Triangle& triangle) {
    const std::vector<Vec3>& at = mesh.vertices();
    return are_collinear(at[triangle[0]], at[triangle[1]], at[triangle[2]]);
}

}  // namespace

Defects find_defects(const Mesh& mesh) {
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    Defects defects;
    Parts parts(mesh.vertices().size());
    std::vector<bool> used(mesh.vertices().size(), false);
    std::vector<Triangle> sorted;
    for (Triangle triangle : mesh.triangles()) {
        for (std::uint32_t& index : triangle) {
            index = first[index];
            used[index] = true;
            parts.join(triangle[0], index);
        }
        std::sort(triangle.begin(), triangle.end());
        if (triangle[0] == triangle[1] || triangle[1] == triangle[2]) continue;
        sorted.push_back(triangle);
        defects.zero_area_faces += has_no_area(mesh, triangle);
    }
    std::sort(sorted.begin(), sorted.end());
    const auto distinct = std::unique(sorted.begin(), sorted.end());
    defects.duplicate_faces = static_cast<std::size_t>(sorted.end() - distinct);
    for (std::uint32_t vertex = 0; vertex < used.size(); ++vertex)
        defects.components += used[vertex] && parts.part_of(vertex) == vertex;
    return defects;
}

}  // namespace clsdf

#include "polyhedra/ordered_faces.hpp"

#include "core/parallel.hpp"
#include "polyhedra/one_rings.hpp"

namespace clsdf::polyhedra {

OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order, ScratchMemory* scratch) {
    check_face_count(order.size());
    constexpr std::uint32_t none = UINT32_MAX;
    const std::size_t vertex_count = mesh.vertices().size();

    OrderedFaces faces;
    faces.triangles = UninitializedVector<Triangle>(order.size(), scratch);
    for_each_index(order.size(), [&](std::size_t face) { faces.triangles[face] = mesh.triangles()[order[face]]; });

    // By one thread: several would write to the same cache lines, and take longer (on two cores).
    UninitializedVector<std::uint32_t> numbers(vertex_count, none, scratch);
    faces.vertices = UninitializedVector<std::uint32_t>(vertex_count + 1, scratch);
    std::uint32_t count = 0;
    for (std::size_t face = 0; face < order.size(); ++face) {
        if (face % OrderedFaces::stretch == 0) faces.first_vertices.push_back(count);
        for (std::uint32_t& vertex : faces.triangles[face]) {
            const std::uint32_t known = numbers[vertex];
            const bool is_new = known == none;  // not a branch: that could not be predicted
            faces.vertices[count] = vertex;
            numbers[vertex] = is_new ? count : known;
            vertex = is_new ? count : known;
            count += is_new ? 1U : 0U;
        }
    }
    faces.first_vertices.push_back(count);
    faces.vertices.resize(count);

    faces.positions = UninitializedVector<Vec3>(count, scratch);
    for_each_index(count, [&](std::size_t i) { faces.positions[i] = mesh.vertices()[faces.vertices[i]]; });
    return faces;
}

}  // namespace clsdf::polyhedra

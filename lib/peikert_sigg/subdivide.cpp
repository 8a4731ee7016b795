#include "core/parallel.hpp"
#include "peikert_sigg/gap_test.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace clsdf {

namespace {

using namespace peikert_sigg;
using polyhedra::next_of_three;
using polyhedra::VertexFans;

double squared_length(const Surface& surface, const Corner& edge) {
    const Triangle& triangle = surface.triangles()[edge.face];
    const Vector from = polyhedra::to_vector(surface.position(triangle[edge.vertex]));
    return (polyhedra::to_vector(surface.position(triangle[next_of_three(edge.vertex)])) - from).squaredNorm();
}

/// What is to be done about a vertex.
struct Remedy {
    bool irregular = false;
    std::optional<Corner> edge;  ///< to cut: opposite to the vertex, the longest among its flipped faces
};

Remedy remedy_for(const Surface& surface, std::size_t vertex, VertexFans& fans) {
    if (surface.kind(vertex, fans) != VertexKind::saddle) return {};
    const Fan fan = fan_at(surface, vertex, fans);
    FanSigns signs(fan);
    const std::vector<std::size_t> flipped = flipped_faces(signs);
    Remedy remedy{!flipped.empty(), std::nullopt};
    if (!remedy.irregular || !has_view(signs)) return remedy;
    for (const std::size_t i : flipped) {
        const Corner& corner = fans.faces()[i].corner;
        const Corner opposite{corner.face, next_of_three(corner.vertex)};
        if (!remedy.edge || squared_length(surface, opposite) > squared_length(surface, *remedy.edge))
            remedy.edge = opposite;
    }
    return remedy;
}

std::vector<Remedy> remedies(const Surface& surface) {
    std::vector<Remedy> result(surface.mesh().vertices().size());
    tbb::enumerable_thread_specific<VertexFans> fans_of_thread;
    for_each_index(result.size(),
                   [&](std::size_t vertex) { result[vertex] = remedy_for(surface, vertex, fans_of_thread.local()); });
    return result;
}

/// Cuts every face at each of the edges in two; an edge of which some face is cut already has to wait.
Mesh cut(const Surface& surface, const std::vector<Remedy>& remedies) {
    std::vector<Vec3> vertices = surface.mesh().vertices();
    std::vector<Triangle> triangles = surface.mesh().triangles();
    std::vector<bool> is_cut(surface.triangles().size(), false);
    for (const auto& [irregular, edge] : remedies) {
        if (!edge) continue;
        const std::vector<Corner> uses = surface.edges_at(*edge);
        bool waits = false;
        for (const Corner& use : uses) waits = waits || is_cut[use.face];
        if (waits) continue;

        const auto middle = static_cast<std::uint32_t>(vertices.size());
        const Triangle& cut_triangle = surface.triangles()[edge->face];
        const Vec3& from = surface.position(cut_triangle[edge->vertex]);
        const Vec3& to = surface.position(cut_triangle[next_of_three(edge->vertex)]);
        vertices.push_back({from[0] / 2 + to[0] / 2, from[1] / 2 + to[1] / 2, from[2] / 2 + to[2] / 2});
        for (const Corner& use : uses) {
            is_cut[use.face] = true;
            const std::uint32_t source = surface.sources()[use.face];
            const Triangle whole = triangles[source];
            triangles[source][next_of_three(use.vertex)] = middle;
            Triangle rest = whole;
            rest[use.vertex] = middle;
            triangles.push_back(rest);
        }
    }
    return {std::move(vertices), std::move(triangles), surface.mesh().name()};
}

}  // namespace

RegularMesh subdivide_irregular(const Mesh& mesh, std::size_t rounds) {
    RegularMesh result{mesh};
    for (std::size_t round = 0;; ++round) {
        const Surface surface(result.mesh);
        const std::vector<Remedy> found = remedies(surface);
        const auto count = [&](const auto& property) {
            return static_cast<std::size_t>(std::count_if(found.begin(), found.end(), property));
        };
        result.irregular_vertices = count([](const Remedy& remedy) { return remedy.irregular; });
        result.added_vertices = result.mesh.vertices().size() - mesh.vertices().size();
        if (round == rounds || count([](const Remedy& remedy) { return remedy.edge.has_value(); }) == 0) return result;
        result.mesh = cut(surface, found);
    }
}

}  // namespace clsdf

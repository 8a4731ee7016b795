#include "peikert_sigg/surface.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edges_of_vertex.hpp"

#include <tbb/enumerable_thread_specific.h>

namespace clsdf {

namespace {

constexpr std::array<const char*, edge_kinds> edge_names{"convex",   "concave",    "flat",
                                                         "boundary", "unoriented", "non-manifold"};
constexpr std::array<const char*, vertex_kinds> vertex_names{"convex",   "concave",      "flat",  "saddle",
                                                             "boundary", "non-manifold", "unused"};

}  // namespace

const char* name_of(EdgeKind kind) {
    return edge_names[static_cast<std::size_t>(kind)];
}

const char* name_of(VertexKind kind) {
    return vertex_names[static_cast<std::size_t>(kind)];
}

Classification classify(const Mesh& mesh) {
    using namespace polyhedra;
    const peikert_sigg::Surface surface(mesh);
    const std::vector<std::uint32_t>& representatives = surface.representatives();

    Classification result;
    result.vertices.assign(mesh.vertices().size(), VertexKind::unused);
    tbb::enumerable_thread_specific<VertexFans> fans_of_thread;
    for_each_index(mesh.vertices().size(),
                   [&](std::size_t vertex) { result.vertices[vertex] = surface.kind(vertex, fans_of_thread.local()); });
    for (std::size_t vertex = 0; vertex < result.vertices.size(); ++vertex) {
        VertexKind& kind = result.vertices[vertex];
        const bool counts = representatives[vertex] == vertex;
        if (!counts) kind = result.vertices[representatives[vertex]];
        result.vertex_counts[static_cast<std::size_t>(kind)] += counts;
    }
    std::vector<EdgeEntry> entries;
    for (std::uint32_t vertex = 0; vertex < result.vertices.size(); ++vertex) {
        edges_above(surface.triangles(), surface.rings(), vertex, entries);
        for_each_edge(entries, [&](std::span<const EdgeEntry> faces) {
            ++result.edge_counts[static_cast<std::size_t>(surface.kind(faces.front().edge()))];
        });
    }
    return result;
}

}  // namespace clsdf
